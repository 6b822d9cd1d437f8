"""`compensate`: command poses that reach the targets under load."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, get_args

import numpy as np
import pandas as pd

from expdesign.app.api.inputs import REFUTED, ModelInput, TableInput, model_of, purpose_of, table_of
from expdesign.app.api.result import Result, TableResult
from expdesign.arrays import FloatArray
from expdesign.assurance.plausibility.finding import say
from expdesign.assurance.plausibility.targets import correction_findings, target_findings
from expdesign.chain.models.estimable import Calibrated
from expdesign.chain.models.model_file import Model
from expdesign.chain.readings.position import Frame
from expdesign.chain.recordings.joint_columns import with_joint_columns
from expdesign.chain.recordings.points import points_from_table
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.coordinates import SPATIAL
from expdesign.errors import ArgumentError
from expdesign.estimation.compensation.arm_targets import arm_targets
from expdesign.estimation.compensation.compensate import Compensation, Corrections, compensate_arm, corrections_of
from expdesign.estimation.compensation.compensate import compensate as commands_for
from expdesign.estimation.compensation.prediction import in_file_order, require_history
from expdesign.io.output import csv_text
from expdesign.io.table import Table, parse_table
from expdesign.mechanics.robots.corrected_urdf import pose_of
from expdesign.mechanics.robots.robot import Robot
from expdesign.mechanics.robots.urdf import transform

if TYPE_CHECKING:  # most commands are found without a configuration, and need not wait for planning
    from expdesign.app.api.configuration import Config
    from expdesign.planning.problem import DesignProblem

MOST_LINES = 20
"""Targets that are listed; of more the largest corrections are."""
_SAMPLES = 200
"""Measurements drawn from the design space, whose corners are added."""
_CONFIGURATIONS = (".yaml", ".yml")


@dataclass(frozen=True, repr=False)
class CompensationResult(TableResult):
    """What to command.

    Attributes:
        text: the targets as they stand in a file, with the command in the pose columns.
        compensation: the same as arrays, rows in the order of their sequence, and how the commands were found.
        corrections: how large they are, and how well the attained pose is known, in the same order.
        sequence: numbers of the targets, in the same order.
        robot: that is commanded.
        refuted: whether the recordings of the model refute it.
    """

    compensation: Compensation
    corrections: Corrections
    sequence: list[int]
    robot: Robot
    refuted: bool = False

    @property
    def summary(self) -> str:
        """The largest correction and the expected uncertainty, in words."""
        return correction_summary(self.corrections, self.robot.coordinates.translations)

    @property
    def lines(self) -> list[str]:
        """Corrections and expected uncertainties as a table in words, a line for each target, and the summary."""
        table = correction_lines(self.corrections, self.sequence, self.robot.coordinates.translations)
        return [*table, self.summary]

    @property
    def notes(self) -> list[str]:
        """That the model is refuted."""
        return [REFUTED] if self.refuted else []


def compensate(
    model: ModelInput, targets: "TableInput | Config", *, other_robot: bool = False, frame: Frame = "base"
) -> CompensationResult:
    """Find the commands that bring the platform to the targets under load.

    The load is that at the target: a payload's wrench is taken at the orientation that the platform shall have. For an
    arm, targets are poses `x_m` ... `rz_rad` of the tip, with joint columns as the posture to stay near, or joint
    columns alone: the pose that the nominal robot has there.

    Args:
        model: identified model (YAML).
        targets: targets (CSV): where the platform shall be, and the load there; or a run configuration (YAML) with its
            targets.
        other_robot: a configuration of another geometry than the model's is meant.
        frame: of the poses of an arm's tip: `base`, or `instrument` as it was identified.

    Raises:
        InputError: a file is missing or wrong, or a target cannot be meant.
        ConvergenceError: no command is found.
        SingularConfigurationError: the robot is singular at a target.
        InfeasibleError: a command is beyond the robot's limits.

    Example:
        >>> xd.compensate("identified/model.yaml", "configs/bipod.yaml").summary
        'largest correction 72.1 um; expected U 0.993 um'

    Command:
        expdesign compensate results/mine/model.yaml targets.csv --out commands.csv
    """
    identified = model_of(model)
    robot = identified.chain.robot
    problem = _configuration(targets, robot, identified.source, confirmed=other_robot)
    table = _table(targets, problem)
    require_history(identified, table)
    if frame not in get_args(Frame):
        raise ArgumentError(f"`{frame}` is no frame", argument="frame", remedy="Choose base or instrument.")
    commanded = _of_platform if not robot.jointed else _of_arm
    text, found, corrections, points = commanded(identified, table, frame, problem)
    purpose, refuted = purpose_of("compensate", model, targets), identified.fit == "refuted"
    return CompensationResult(text, found, corrections, points.sequence.tolist(), robot, refuted, purpose=purpose)


def _configuration(
    targets: "TableInput | Config", robot: Robot, source: str, *, confirmed: bool
) -> "DesignProblem | None":
    """The run configuration that holds the targets, or None where they are a table."""
    if isinstance(targets, pd.DataFrame | Result):
        return None
    if isinstance(targets, str | Path) and Path(targets).suffix.lower() not in _CONFIGURATIONS:
        return None
    from expdesign.app.api.configuration import problem_of_robot  # noqa: PLC0415

    return problem_of_robot(targets, robot, source, confirmed=confirmed)


def _table(targets: "TableInput | Config", problem: "DesignProblem | None") -> Table:
    if problem is None:
        return table_of(targets, "targets")  # type: ignore[arg-type]
    return targets_table(problem)


def targets_table(problem: "DesignProblem") -> Table:
    """The targets with their loads, one row each, numbered as in the configuration."""
    robot, count = problem.loaded.robot, len(problem.targets.configurations)
    columns: dict[str, object] = {"sequence": np.arange(1, count + 1), "series": np.arange(1, count + 1)}
    columns |= {name: problem.targets.configurations[:, i] for i, name in enumerate(robot.configuration)}
    if all(loaded.load.has_mass for loaded, _ in problem.target_loads):
        names = problem.target_loads[0][0].load.columns
        values = np.array([parameters for _, parameters in problem.target_loads])
    else:
        names, values = robot.coordinates.wrench, problem.target_wrenches
    own = dict(zip(robot.coordinates.gravity, robot.gravity, strict=True))
    for i, name in enumerate(names):
        if name not in own or np.any(values[:, i] != own[name]):
            columns[name] = values[:, i]
    return parse_table(csv_text(pd.DataFrame(columns)), f"{problem.source}, targets")


def calibrated_by(problem: "DesignProblem") -> Calibrated:
    """The ranges of what a configuration lets be measured."""
    space, robot = problem.space, problem.loaded.robot
    drawn = space.sample(_SAMPLES, np.random.default_rng(0))
    configurations, loads = space.decode(np.concatenate([drawn, np.stack([space.lower, space.upper])]))
    columns = {name: configurations[:, i] for i, name in enumerate(robot.configuration)}
    columns |= {name: loads[:, i] for i, name in enumerate(problem.loaded.load.columns)}
    table = parse_table(csv_text(pd.DataFrame(columns)), problem.source)
    return Calibrated.of(points_from_table(table, robot), robot)


def _of_platform(
    model: Model, table: Table, frame: Frame, problem: "DesignProblem | None"
) -> tuple[pd.DataFrame, Compensation, Corrections, LoadedPoints]:
    """Poses to command; they are in the base frame."""
    robot = model.chain.robot
    points = points_from_table(table, robot)
    calibrated = _calibrated(model, points, problem)
    found = commands_for(model, points)
    corrections = _corrections(robot, points, found, calibrated)
    return _with_commands(table.frame.copy(), points, robot, found, corrections), found, corrections, points


def _calibrated(model: Model, points: LoadedPoints, problem: "DesignProblem | None") -> Calibrated | None:
    """What was calibrated, against which the targets have been judged.

    Springs alone act alike wherever the configuration lets them be measured: where its plan stays in some corners, the
    poses and loads between them count as calibrated as well. What a diagnosis has added holds where it was recorded.
    """
    calibrated = model.calibrated
    if problem is not None and (calibrated is None or not model.chain.effects):
        calibrated = calibrated_by(problem).including(calibrated)
    say(target_findings(points, model.chain.robot, calibrated), points.source)
    return calibrated


def _corrections(robot: Robot, points: LoadedPoints, found: Compensation, calibrated: Calibrated | None) -> Corrections:
    """The corrections, which are judged where nothing says what was calibrated."""
    corrections = corrections_of(robot, points, found, calibrated)
    if calibrated is None:
        say(correction_findings(robot, points, corrections.translation, corrections.rotation), points.source)
    return corrections


def _with_commands(
    frame: pd.DataFrame, points: LoadedPoints, robot: Robot, found: Compensation, corrections: Corrections
) -> pd.DataFrame:
    """The table of the targets with commands, corrections and uncertainties, rows as in the file."""
    coordinates = robot.coordinates
    columns = dict(zip(robot.configuration, found.commands.T, strict=True))
    columns |= {f"target_{name}": points.configurations[:, i] for i, name in enumerate(robot.configuration)}
    columns |= {f"leg{leg + 1}_m": lengths for leg, lengths in enumerate(found.lengths.T)}
    columns |= dict(zip(coordinates.deviation, found.deviations.T, strict=True))
    for name, values in columns.items():
        (frame[name],) = in_file_order(points, values)
    _judge(frame, points, robot, corrections)
    return frame


def _judge(frame: pd.DataFrame, points: LoadedPoints, robot: Robot, corrections: Corrections) -> None:
    """Add how large corrections are, how well the attained pose is known, and what lies beyond the calibration."""
    columns = {"correction_m": corrections.translation}
    if robot.coordinates.rotations:
        columns["correction_rad"] = corrections.rotation
    names = SPATIAL.pose if robot.jointed else robot.coordinates.pose
    columns |= {f"U_{name}": corrections.expanded[:, i] for i, name in enumerate(names)}
    for name, values in columns.items():
        (frame[name],) = in_file_order(points, values)
    (order,) = in_file_order(points, np.arange(len(points), dtype=float))
    frame["beyond_calibration"] = ["; ".join(map(str, corrections.beyond[int(row)])) for row in order]


def _of_arm(
    model: Model, table: Table, frame: Frame, problem: "DesignProblem | None"
) -> tuple[pd.DataFrame, Compensation, Corrections, LoadedPoints]:
    """Joint commands, and the pose to ask of a controller that has the nominal geometry."""
    robot = model.chain.robot
    targets = arm_targets(table, model, frame)
    points = targets.points
    calibrated = _calibrated(model, points, problem)
    found = compensate_arm(model, targets)
    corrections = _corrections(robot, points, found, calibrated)
    nominal = _poses(robot.position(found.commands), robot.jacobians(found.commands).rotation)
    wanted = _poses(targets.positions, targets.rotations) if targets.stated is None else targets.stated
    commands, deviations, nominal, wanted, own = in_file_order(
        points, found.commands, found.deviations, nominal, wanted, points.configurations
    )
    text = table.frame.copy()
    joints = len(robot.stiffness)
    names = dict(zip(with_joint_columns(table, robot).columns, table.columns, strict=True))
    for axis, name in enumerate(robot.configuration[:joints]):
        text[names.get(name, name)] = commands[:, axis]
        text[f"target_{name}"] = own[:, axis]  # where the nominal robot is there: `verify` takes the load there
    for axis, name in enumerate(SPATIAL.pose):
        text[f"target_{name}"] = wanted[:, axis]
        text[f"controller_{name}"] = nominal[:, axis]
    for axis, name in enumerate(robot.coordinates.deviation):
        text[name] = deviations[:, axis]
    text = text.drop(columns=[name for name in SPATIAL.pose if name in text])
    _judge(text, points, robot, corrections)
    return text, found, corrections, points


def _poses(positions: FloatArray, rotations: FloatArray) -> FloatArray:
    """Poses (N, 6) of frames."""
    return np.array(
        [pose_of(transform(rotation, position)) for rotation, position in zip(rotations, positions, strict=True)]
    )


def correction_lines(corrections: Corrections, sequence: list[int], translations: int) -> list[str]:
    """A table of the corrections, rows in the order of the targets.

    Args:
        corrections: of N targets.
        sequence: their numbers, N.
        translations: number of leading axes that are lengths.
    """
    count = len(sequence)
    chosen = np.arange(count)
    if count > MOST_LINES:
        chosen = np.sort(np.argsort(-corrections.translation, kind="stable")[:MOST_LINES])
    rows = [("target", "correction", "", "U (k = 2)", "", "beyond what was calibrated")]
    for row in chosen:
        length, angle = _parts(corrections.expanded[row], translations)
        rows.append(
            (
                str(sequence[row]),
                metres(float(corrections.translation[row])),
                radians(float(corrections.rotation[row])) if angle is not None else "",
                metres(length),
                "" if angle is None else radians(angle),
                "; ".join(map(str, corrections.beyond[row])) or "-",
            )
        )
    widths = [max(len(row[column]) for row in rows) for column in range(5)]
    lines = ["  ".join([*(cell.rjust(w) for cell, w in zip(row, widths, strict=False)), row[5]]) for row in rows]
    if count > MOST_LINES:
        lines.append(f"({count - MOST_LINES} smaller corrections are in the file)")
    return lines


def correction_summary(corrections: Corrections, translations: int) -> str:
    """The largest correction and the largest uncertainty."""
    length, angle = _parts(corrections.expanded, translations)
    size = [metres(float(corrections.translation.max()))]
    known = [metres(length)]
    if angle is not None:
        size.append(radians(float(corrections.rotation.max())))
        known.append(radians(angle))
    text = f"largest correction {', '.join(size)}; expected U {', '.join(known)}"
    outside = sum(bool(row) for row in corrections.beyond)
    if outside:
        text += f"; {outside} of {len(corrections.beyond)} targets beyond what was calibrated"
    return text


def metres(value: float) -> str:
    """A length in µm, in mm from 1 mm on."""
    return _scaled(value, "m")


def radians(value: float) -> str:
    """An angle in µrad, in mrad from 1 mrad on."""
    return _scaled(value, "rad")


def _scaled(value: float, unit: str) -> str:
    if not np.isfinite(value):
        return "not determined"
    return f"{value * 1e3:.3g} m{unit}" if value >= 1e-3 else f"{value * 1e6:.3g} u{unit}"


def _parts(expanded: FloatArray, translations: int) -> tuple[float, float | None]:
    """Largest U of lengths and of angles, None where there are none."""
    lengths, angles = expanded[..., :translations], expanded[..., translations:]
    return float(lengths.max()), float(angles.max()) if angles.shape[-1] else None
