"""`compensate`: command poses that reach the targets under load."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from expdesign.app.api.arguments import named_arguments
from expdesign.app.api.inputs import ModelInput, TableInput, load_model, purpose_of, table_of
from expdesign.app.api.points_said import say_unknown_columns
from expdesign.arrays import FloatArray
from expdesign.assurance.plausibility.finding import say
from expdesign.assurance.plausibility.targets import correction_findings, pose_findings, target_findings
from expdesign.chain.models.estimable import Calibrated
from expdesign.chain.models.model_file import Model
from expdesign.chain.readings.position import Frame
from expdesign.chain.recordings.joint_columns import with_joint_columns
from expdesign.chain.recordings.points import points_from_table
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.coordinates import SPATIAL
from expdesign.estimation.compensation.arm_targets import ArmTargets, arm_targets, base_as_drawn, poses_of
from expdesign.estimation.compensation.compensate import Compensation, Corrections, compensate_arm, corrections_of
from expdesign.estimation.compensation.compensate import compensate as commands_for
from expdesign.estimation.compensation.prediction import after_campaign, in_file_order, require_history
from expdesign.estimation.compensation.target_loads import TargetLoads, said_of_loads
from expdesign.io.table import Table
from expdesign.mechanics.robots.robot import Robot
from expdesign.report.compensation_texts import BASE_AS_DRAWN, CompensationResult, tip_as_drawn
from expdesign.report.result import Result

if TYPE_CHECKING:  # most commands are found without a configuration, and need not wait for planning
    from expdesign.app.api.configuration import Config
    from expdesign.planning.problem import DesignProblem


@named_arguments
def compensate(
    model: ModelInput, targets: TableInput | Config, *, other_robot: bool = False, frame: Frame = "base"
) -> CompensationResult:
    """Find the commands that bring the platform to the targets under load.

    The load is that at the target: a payload's wrench is taken at the wanted orientation of the platform. For an
    arm, targets are poses `x_m` ... `rz_rad` of the tip, with joint columns as the posture to stay near, or joint
    columns alone: the pose that the nominal robot has there.

    An error of the loads that the model's recordings showed belongs to their weights. It acts at a target only where
    the column `same_as` says `experiment`; a target carries a payload of its own otherwise, whose standard deviations
    `error_mass_kg`, `error_com_x_m` ... are in U.

    Args:
        model: identified model (YAML).
        targets: poses that the platform shall reach, with the load at each (CSV); or a run configuration (YAML) with
            targets.
        other_robot: accept a configuration whose robot has another geometry.
        frame: frame of the target poses of an arm's tip: `base`, or `instrument` as identified.

    Raises:
        InputError: a file is missing or wrong, or a target cannot be meant.
        ConvergenceError: no command is found.
        SingularConfigurationError: the robot is singular at a target.
        InfeasibleError: a command is beyond the robot's limits.

    Example:
        >>> xd.compensate("identified/model.yaml", "configs/bipod.yaml").summary
        'largest correction 72.1 µm; expected U 0.993 µm'

    Command:
        expdesign compensate results/mine/model.yaml targets.csv --out commands.csv
    """
    identified = load_model(model)
    robot = identified.chain.robot
    problem = None
    if not _is_table(targets):
        from expdesign.app.api.configuration import problem_of_robot  # noqa: PLC0415 (of configurations)
        from expdesign.planning.target_table import targets_table  # noqa: PLC0415 (of configurations)

        problem = problem_of_robot(targets, robot, identified.source, confirmed=other_robot)  # type: ignore[arg-type]
    table = table_of(targets, "targets") if problem is None else targets_table(problem)  # type: ignore[arg-type]
    loads = TargetLoads.of_table(table, robot.coordinates)
    require_history(identified, table)
    if robot.jointed and any(table.has(name) for name in SPATIAL.pose[:3]):
        say(pose_findings(robot, table.numbers(SPATIAL.pose), "targets", SPATIAL.pose), table.source)
    aims = arm_targets(table, identified, frame) if robot.jointed else None
    stated = points_from_table(table, robot) if aims is None else aims.points
    say_unknown_columns(stated)
    points = after_campaign(identified, stated)
    aims = aims if aims is None else replace(aims, points=points)
    calibrated = _calibrated(identified, points, problem)
    found = commands_for(identified, points, loads) if aims is None else compensate_arm(identified, aims, loads)
    corrections = corrections_of(robot, points, found, calibrated)
    if calibrated is None:
        say(correction_findings(robot, points, corrections.translation, corrections.rotation), points.source)
    own = _of_platform(points, robot, found) if aims is None else _of_arm(table, robot, found, aims)
    columns = own | _judged(robot, corrections)
    text = table.frame.drop(columns=[name for name in SPATIAL.pose if robot.jointed and table.has(name)])
    text = text.assign(**dict(zip(columns, in_file_order(points, *columns.values()), strict=True)))
    purpose, refuted = purpose_of("compensate", model, targets), identified.fit == "refuted"
    scope, sequence = said_of_loads(identified.at_targets, loads), stated.sequence.tolist()
    if points is not stated:
        after = f"row {points.sequence[0]}"
        scope.append(f"all targets are taken after the campaign ({after}): the model drifts along `sequence`")
    if found.drawn is not None and (found.drawn > found.deviations / np.sqrt(2.0)).any():
        scope.append(tip_as_drawn(found.drawn))
    if base_as_drawn(identified, frame):
        scope.append(BASE_AS_DRAWN)
    return CompensationResult(text, found, corrections, sequence, robot, refuted, scope, purpose=purpose)


def _is_table(targets: object) -> bool:
    """Whether targets are, or are meant as, a table, and no run configuration that holds some."""
    named = isinstance(targets, str | Path) and Path(targets).suffix.lower() not in (".yaml", ".yml")
    return named or isinstance(targets, pd.DataFrame | Result | list | tuple | np.ndarray)


def _calibrated(model: Model, points: LoadedPoints, problem: DesignProblem | None) -> Calibrated | None:
    """What was calibrated, against which the targets have been judged.

    Springs alone act alike wherever the configuration lets them be measured: where its plan stays in some corners, the
    poses and loads between them count as calibrated as well. What a diagnosis has added holds where it was recorded.
    """
    calibrated = model.calibrated
    if problem is not None and (calibrated is None or not model.chain.effects):
        from expdesign.assurance.plausibility.configured import calibrated_by  # noqa: PLC0415 (of configurations)

        calibrated = calibrated_by(problem).including(calibrated)
    say(target_findings(points, model.chain.robot, calibrated), points.source)
    return calibrated


def _of_platform(points: LoadedPoints, robot: Robot, found: Compensation) -> dict[str, FloatArray]:
    """Columns of the poses to command; they are in the base frame."""
    columns = dict(zip(robot.configuration, found.commands.T, strict=True))
    columns |= {f"target_{name}": points.configurations[:, i] for i, name in enumerate(robot.configuration)}
    columns |= {f"leg{leg + 1}_m": lengths for leg, lengths in enumerate(found.lengths.T)}
    return columns | dict(zip(robot.coordinates.deviation, found.deviations.T, strict=True))


def _of_arm(table: Table, robot: Robot, found: Compensation, aims: ArmTargets) -> dict[str, FloatArray]:
    """Columns of joint commands, and of the pose to ask of a controller that has the nominal geometry."""
    nominal = poses_of(robot.position(found.commands), robot.jacobians(found.commands).rotation)
    names = dict(zip(with_joint_columns(table, robot).columns, table.columns, strict=True))
    columns: dict[str, FloatArray] = {}
    for axis, name in enumerate(robot.configuration[: len(robot.stiffness)]):
        columns[names.get(name, name)] = found.commands[:, axis]
        # Where the nominal robot is there: `verify` takes the load there.
        columns[f"target_{name}"] = aims.points.configurations[:, axis]
    for axis, name in enumerate(SPATIAL.pose):
        columns |= {f"target_{name}": aims.stated[:, axis], f"controller_{name}": nominal[:, axis]}
    return columns | dict(zip(robot.coordinates.deviation, found.deviations.T, strict=True))


def _judged(robot: Robot, corrections: Corrections) -> dict[str, Any]:
    """Columns of how large corrections are, how well the attained pose is known, and what was not calibrated."""
    names = SPATIAL.pose if robot.jointed else robot.coordinates.pose
    columns: dict[str, Any] = {"correction_m": corrections.translation}
    columns |= {"correction_rad": corrections.rotation} if robot.coordinates.rotations else {}
    columns |= {f"U_{name}": corrections.expanded[:, i] for i, name in enumerate(names)}
    beyond = ["; ".join(map(str, row)) for row in corrections.beyond]
    return columns | {"beyond_calibration": np.array(beyond, dtype=object)}
