"""Appendix H: poses freed of thermal deflection by a reference pose, and the price in noise."""

from typing import Annotated

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field

from expdesign.arrays import FloatArray, IntArray
from expdesign.assurance.validation.repeated import mean
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.estimation.preparation.thermal_correction import (
    CorrectedPoses,
    MeasuredPoses,
    correct_poses,
)
from expdesign.io.schema import Count, Number, Positive
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.robots.robot_file import read_robot
from research.studies.drawing import COLOURS, panels
from research.studies.pose_errors import AXES, MICRO, deviation_table
from research.studies.study import Picture, Piece, Study, StudySection, StudyTable, Tables, Text
from research.studies.tables import column, rows_of

METHODS = ("none", "reference before", "interpolated")
DRIFTS = {"steps": "in steps before each reference", "warm-up": "steady warm-up"}


class Settings(StudySection):
    """Configuration of the study."""

    robot: str = Field(description="Robot file; the path is relative to this file.")
    reference: Annotated[list[Number], Field(min_length=6, max_length=6)] = Field(
        description="Reference pose (m, rad)."
    )
    poses: Count = Field(description="Number of measured poses.")
    poses_seed: Annotated[int, Field(strict=True, ge=0)] = Field(description="Seed of the measured poses.")
    half_ranges: Annotated[list[Positive], Field(min_length=6, max_length=6)] = Field(
        description="Half-ranges of the measured poses (m, rad)."
    )
    deviations: Annotated[list[Positive], Field(min_length=6, max_length=6)] = Field(
        description="Standard deviations of a measured pose (m, rad)."
    )
    growth_m: Annotated[list[Number], Field(min_length=6, max_length=6)] = Field(
        description="Growth of each leg in the end (m)."
    )
    time_constant: Positive = Field(description="Time constant of the growth, in measured poses.")


class ThermalReference(Study):
    """RMS of measured poses with and without the correction, for two kinds of drift."""

    title = "Appendix H: pose measurement freed of thermal deflection"
    settings = Settings

    def tables(self, settings: Settings, document: YamlDocument) -> dict[str, StudyTable]:
        given = read_robot(document.folder / settings.robot)
        if not given.on_legs:
            raise settings.where("robot").fault("the study needs a robot on legs", "Name a hexapod.")
        robot = given.inverse_kinematics
        commands = _commands(settings)
        growths = _growths(settings)
        frames, series = [], []
        for name, growth in growths.items():
            for method in METHODS:
                frames.append(_rms(robot, settings, commands, growth, name, method))
                exact, truth = _exact(robot, settings, commands, growth, method)
                for pose, value in enumerate(MICRO * (exact - truth)[:, 2]):
                    series.append({"drift": name, "method": method, "pose": pose + 1, "z_um": float(value)})
        return {
            "rms": StudyTable(pd.concat(frames, ignore_index=True)),
            "left": StudyTable(pd.DataFrame(series), digits=5),
            "price": StudyTable(_price(robot, settings, commands)),
        }

    def figures(self, settings: Settings, tables: Tables) -> dict[str, Figure]:
        figure, axes = panels(1, 2, 3.8, 2.7)
        for axis, (drift, rows) in zip(axes, tables["left"].groupby("drift", sort=False)):
            for colour, (method, part) in zip(COLOURS, rows.groupby("method", sort=False)):
                axis.plot(column(part, "pose"), column(part, "z_um"), color=colour, label=str(method))
            axis.set_title(f"drift: {DRIFTS[str(drift)]}")
            axis.set_xlabel("pose")
            axis.set_ylabel("error of z without noise (µm)")
            axis.legend(fontsize=7)
        return {"left": figure}

    def page(self, settings: Settings, tables: Tables) -> list[Piece]:
        rms = {(row.drift, row.method, row.axis): row for row in rows_of(tables["rms"])}
        z = AXES[2]
        before, after = rms["steps", "none", z], rms["steps", "reference before", z]
        price = column(tables["price"], "price")
        interpolated, plain = rms["warm-up", "interpolated", z], rms["warm-up", "reference before", z]
        return [
            Text("## What is corrected"),
            Text(
                f"{settings.poses} poses are measured while the legs grow by micrometres, a reference pose before "
                "each. Where the growth happens between a pose and the next reference, the correction removes it: the "
                f"RMS error of z falls from {before.rms:.3f} to {after.rms:.3f} µm, which is noise alone "
                f"({after.rms_predicted:.3f} µm predicted). The reconstruction's example: 1.36 to 0.52 µm."
            ),
            Text(
                "Where the legs warm up steadily, the reference lags behind by one measurement, and interpolation "
                f"between the references before and after the pose helps: {plain.rms:.3f} and "
                f"{interpolated.rms:.3f} µm. Its noise is smaller too, because two references are averaged."
            ),
            Picture("left", "What drift leaves of the error of z, without noise."),
            Text("## What it costs"),
            Text(
                "A corrected pose has the covariance V + 2TVTᵀ, T = J̌(X)J̌(X_R)⁻¹. Here that is "
                f"{price.min():.3f} to {price.max():.3f} times the standard deviation of an uncorrected one (√3 = "
                "1.732 where T is the identity)."
            ),
            Text(
                f"RMS error over all poses from {settings.samples} repetitions, beside the prediction "
                "√(noise² + what drift leaves²):"
            ),
            deviation_table(tables["rms"], {"drift": "drift", "method": "correction", "axis": "axis"}, "rms"),
        ]


def _commands(settings: Settings) -> FloatArray:
    """Reference and pose in turn, and a last reference, shape (2·poses + 1, 6)."""
    generator = np.random.default_rng(settings.poses_seed)
    poses = generator.uniform(-1.0, 1.0, (settings.poses, 6)) * np.array(settings.half_ranges)
    commands = np.tile(np.array(settings.reference), (2 * settings.poses + 1, 1))
    commands[1::2] = poses
    return commands


def _growths(settings: Settings) -> dict[str, FloatArray]:
    """Growth of the legs (m) at every measurement, shape (2·poses + 1, 6)."""
    steps = np.arange(2 * settings.poses + 1.0)
    time = {"steps": 2.0 * np.floor(steps / 2.0), "warm-up": steps}
    return {name: np.outer(1.0 - np.exp(-t / settings.time_constant), settings.growth_m) for name, t in time.items()}


def _measured(commands: FloatArray, poses: FloatArray, settings: Settings) -> MeasuredPoses:
    count = len(commands)
    zero = np.zeros((count, 6))
    number: IntArray = np.arange(count, dtype=np.int64) + 1
    gravity = np.zeros((count, 3))
    empty = pd.DataFrame()
    points = LoadedPoints("", number, number, number, None, commands, zero, zero, None, gravity, None, None, empty)
    return MeasuredPoses(points, number % 2 == 1, poses, np.tile(np.array(settings.deviations), (count, 1)))


def _true_poses(robot: ParallelRobot, commands: FloatArray, growth: FloatArray) -> FloatArray:
    return robot.pose_of(robot.lengths(commands) + growth, commands)


def _corrected(robot: ParallelRobot, measured: MeasuredPoses, method: str) -> FloatArray:
    if method == "none":
        return measured.poses[~measured.reference]
    return correct_poses(robot, measured, interpolate=method == "interpolated").after


def _exact(
    robot: ParallelRobot, settings: Settings, commands: FloatArray, growth: FloatArray, method: str
) -> tuple[FloatArray, FloatArray]:
    """Corrected poses without noise, and the poses with the legs as the first reference found them."""
    poses = _true_poses(robot, commands, growth)
    truth = _true_poses(robot, commands[1::2], np.broadcast_to(growth[0], (settings.poses, 6)))
    return _corrected(robot, _measured(commands, poses, settings), method), truth


def _rms(
    robot: ParallelRobot, settings: Settings, commands: FloatArray, growth: FloatArray, drift: str, method: str
) -> pd.DataFrame:
    poses = _true_poses(robot, commands, growth)
    exact, truth = _exact(robot, settings, commands, growth, method)
    generator = np.random.default_rng([settings.seed, METHODS.index(method), list(DRIFTS).index(drift)])
    squares = np.empty((settings.samples, 6))
    for sample in range(settings.samples):
        noise = generator.standard_normal(poses.shape) * np.array(settings.deviations)
        found = _corrected(robot, _measured(commands, poses + noise, settings), method)
        squares[sample] = ((MICRO * (found - truth)) ** 2).mean(axis=0)
    estimate = mean(squares)
    rms = np.sqrt(estimate.value)
    variance: FloatArray = np.tile(np.array(settings.deviations) ** 2, (settings.poses, 1))
    if method != "none":
        linear = correct_poses(robot, _measured(commands, poses, settings), interpolate=method == "interpolated")
        variance = _variances(linear)
    predicted = MICRO * np.sqrt((variance + (exact - truth) ** 2).mean(axis=0))
    return pd.DataFrame(
        {
            "drift": drift,
            "method": method,
            "axis": AXES,
            "rms": rms,
            "rms_se": estimate.standard_error / (2.0 * rms),
            "rms_predicted": predicted,
            "noise": MICRO * np.sqrt(variance.mean(axis=0)),
        }
    )


def _variances(corrected: CorrectedPoses) -> FloatArray:
    """Variance of every corrected pose along every axis, shape (N, 6)."""
    found = corrected.covariances(np.eye(len(corrected.rows)))
    assert found is not None
    return np.einsum("maa->ma", found[1])


def _price(robot: ParallelRobot, settings: Settings, commands: FloatArray) -> pd.DataFrame:
    """Standard deviation of a corrected pose over that of an uncorrected one, smallest and largest of all poses."""
    linear = correct_poses(robot, _measured(commands, commands, settings))
    # The correction of the pose after the first reference is nothing, and costs nothing.
    ratio = np.sqrt(_variances(linear)[1:]) / np.array(settings.deviations)
    ends = (("least", ratio.min(axis=0)), ("largest", ratio.max(axis=0)))
    rows = [{"axis": axis, "of": of, "price": float(value)} for of, values in ends for axis, value in zip(AXES, values)]
    return pd.DataFrame(rows)
