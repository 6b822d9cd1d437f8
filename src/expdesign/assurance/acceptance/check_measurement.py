"""A check measurement: poses attained at compensated commands, in a table (file-formats.md, Check measurements).

The columns are those that `compensate` wrote, the command in the pose columns and the target in `target_x_m …`, with
what was measured filled in: deflections `dx_m …`, or measured poses `measured_x_m …`, and their standard deviations in
`sx_m …`. A tolerance may stand in `tolerance_dx_m …`. Of an arm measured poses are those of the tip, like their targets
in the frame of the base or of the instrument, and errors a shift and a rotation vector.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.readings.position import Frame
from expdesign.chain.recordings.measured import read_measured
from expdesign.chain.recordings.points import points_from_table
from expdesign.chain.recordings.recordings import DEFLECTIONS, POSES, LoadedPoints, in_order, measured_names
from expdesign.coordinates import SPATIAL
from expdesign.errors import ArgumentError, InputError
from expdesign.estimation.compensation.prediction import moved
from expdesign.io.table import Table
from expdesign.mechanics.robots.orientation import rotations_of
from expdesign.mechanics.robots.robot import Robot

FARTHEST = 0.1
"""m or rad; a measured pose farther from its target is in another unit or frame."""


@dataclass(frozen=True)
class CheckMeasurement:
    """N rows in the order of their sequence.

    Attributes:
        points: commands, and loads as they act at the target.
        targets: configurations that were to be reached, shape (N, n_q).
        axes: indices of the measured components, shape (k,).
        readings: deflections, or measured minus wanted poses, of these components (m, rad), shape (N, k).
        absolute: whether the readings are of poses (else of deflections).
        deviations: standard deviations of the readings, shape (N, k), or None where the table states none.
        poses: of the tip that were wanted of an arm (m, rad), shape (N, 6); None for others, and for deflections.
        tolerance: ± that columns state, shape (N, n), NaN where they do not; None without such columns.
        frame: of measured and wanted poses of an arm's tip, along whose axes `readings` and `deviations` are.
    """

    points: LoadedPoints
    targets: FloatArray
    axes: IntArray
    readings: FloatArray
    absolute: bool
    deviations: FloatArray | None
    tolerance: FloatArray | None
    poses: FloatArray | None = None
    frame: Frame = "base"

    def __len__(self) -> int:
        return len(self.targets)


def read_check_measurement(table: Table, robot: Robot, frame: Frame = "base") -> CheckMeasurement:
    """Read a check measurement.

    Args:
        table: with the columns.
        robot: that was measured.
        frame: of measured and wanted poses.

    Raises:
        ArgumentError: poses of an arm's tip are no readings of it, and alone are in an instrument's frame.
        InputError: there is no target or nothing measured, or anything in the table is missing or cannot be right.
    """
    names = tuple(f"target_{name}" for name in robot.configuration)
    if not any(table.has(name) for name in names):
        what = "there are no targets: these are no recordings at compensated commands"
        remedy = "Measure at the commands that `expdesign compensate` writes, and keep its columns `target_...`."
        raise table.fault(what, column=names[0], remedy=remedy)
    table = in_order(table)
    targets = table.numbers(names)
    commands = table.numbers(robot.configuration)
    # Loads are stated where the platform shall be, as they were for the command.
    there = table.frame.copy()
    for name, target in zip(robot.configuration, names, strict=True):
        there[name] = there[target]
    if robot.jointed:  # what was measured is read below, and is no reading of a marker
        there = there.drop(columns=[name for name in there if str(name).startswith("measured_")])
    points = moved(points_from_table(replace(table, frame=there), robot), commands, robot)
    axes, readings, deviations, absolute = _readings(table, robot, targets)
    wanted = _wanted(table, robot) if absolute and robot.jointed else None
    if frame == "instrument":
        _require_in_space(table, axes, wanted)
    tolerance_names = tuple(f"tolerance_{name}" for name in robot.coordinates.deflection)
    stated = tuple(name for name in tolerance_names if table.has(name))
    table.numbers(stated)
    tolerance = table.numbers_where_filled(tolerance_names) if stated else None
    if tolerance is not None:
        table.refuse(tolerance <= 0.0, tolerance_names, "a tolerance must be positive", "Correct it.")
    return CheckMeasurement(points, targets, axes, readings, absolute, deviations, tolerance, wanted, frame)


def _require_in_space(table: Table, axes: IntArray, wanted: FloatArray | None) -> None:
    """Raise where readings cannot be turned from an instrument's axes."""
    if wanted is None:
        what = "only measured poses of an arm's tip are in the instrument's frame"
        remedy = "Fill in measured_x_m, measured_y_m and measured_z_m, or leave it out."
        raise ArgumentError(what, argument="frame", remedy=remedy)
    if np.isin([0, 1, 2], axes).sum() in (1, 2):
        what = "a position in the instrument's frame has three coordinates"
        where = table.where(column=f"measured_{SPATIAL.pose[2]}")
        raise InputError(what, where=where, remedy="Fill in measured_x_m, measured_y_m and measured_z_m.")


def _readings(table: Table, robot: Robot, targets: FloatArray) -> tuple[IntArray, FloatArray, FloatArray | None, bool]:
    coordinates = robot.coordinates
    measured = measured_names(coordinates)
    if not any(table.has(name) for name in measured):
        return (*read_measured(table, DEFLECTIONS, coordinates), False)
    axes, poses, deviations = read_measured(table, POSES, coordinates)
    errors = poses - targets[:, axes] if not robot.jointed else _of_tip(table, robot, poses, axes)
    away, what = np.abs(errors), "the measured pose is {:.3g} m or rad from its target"
    names = [measured[axis] for axis in axes]
    table.refuse(away > FARTHEST, names, what, "Check the unit (m, rad) and the frame.", away)
    return axes, errors, deviations, True


def _wanted(table: Table, robot: Robot) -> FloatArray:
    """Poses (N, 6) that the tip of an arm should have."""
    return table.numbers(tuple(f"target_{name}" for name in robot.coordinates.pose))


def _of_tip(table: Table, robot: Robot, poses: FloatArray, axes: IntArray) -> FloatArray:
    """Errors (N, k) of measured poses of a tip: shifts, and the rotation vectors of R·R_targetᵀ."""
    wanted = _wanted(table, robot)
    errors = poses - wanted[:, axes]
    turned = axes >= robot.coordinates.translations
    if turned.any():
        if turned.sum() < robot.coordinates.rotations:
            what = "an orientation has three angles"
            where = table.where(column=f"measured_{robot.coordinates.pose[-1]}")
            raise InputError(what, where=where, remedy="Fill them in, or leave all three out.")
        relative = rotations_of(poses[:, turned]) @ rotations_of(wanted[:, 3:]).swapaxes(1, 2)
        errors[:, turned] = Rotation.from_matrix(relative).as_rotvec()
    return errors
