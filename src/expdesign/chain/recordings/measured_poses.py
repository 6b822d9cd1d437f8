"""Tables of absolute measured poses, with a reference pose before each of them (theory.md 9.H).

The columns are those of recordings without deflections, and besides:

    kind                      `reference` (always the same command, without load) or `pose`
    measured_x_m …            the pose as it was measured, in the coordinates of the commanded one
    sx_m …                    standard deviations of the measured pose (optional)
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.chain.recordings.columns import order_in_time, read_deviations, require_one_command
from expdesign.chain.recordings.pose_columns import FARTHEST, KINDS
from expdesign.chain.recordings.reader import points_from_table
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.errors import InputError
from expdesign.io.table import Table
from expdesign.mechanics.robots.parallel import ParallelRobot


@dataclass(frozen=True)
class MeasuredPoses:
    """Measured poses in the order of their sequence.

    Attributes:
        points: commands and loads of N rows.
        reference: which rows are references, shape (N,).
        poses: as measured (m, rad), shape (N, n).
        deviations: standard deviations of `poses`, shape (N, n), or None where they are not stated.
    """

    points: LoadedPoints
    reference: BoolArray
    poses: FloatArray
    deviations: FloatArray | None


def measured_poses(table: Table, robot: ParallelRobot) -> MeasuredPoses:
    """Read measured poses.

    Raises:
        InputError: a column is missing, a reference is loaded or not where the others are, or none stands before the
            first pose.
    """
    names = tuple(f"measured_{name}" for name in robot.coordinates.pose)
    table.require(("sequence", "series", "kind", *names))
    points = points_from_table(table, robot)
    order = order_in_time(table)
    reference: BoolArray = table.words("kind", KINDS, "`{}` is neither `reference` nor `pose`", order) == "reference"
    poses = table.numbers(names)[order]
    what = f"{{:g}} is more than {FARTHEST:g} away from the commanded pose"
    remedy = "Check the unit (m, rad) and the frame: measured and commanded poses are in the same coordinates."
    table.refuse(np.abs(poses - points.configurations) > FARTHEST, names, what, remedy, order, poses)
    _require_references(points, reference)
    rows = np.flatnonzero(~reference)
    require_one_command(table, robot.configuration, points.configurations[rows], points.series[rows], order[rows])
    axes = np.arange(robot.coordinates.n)
    return MeasuredPoses(points, reference, poses, read_deviations(table, robot.coordinates, axes, order))


def _require_references(points: LoadedPoints, reference: BoolArray) -> None:
    rows = np.flatnonzero(reference)
    if not rows.size or not reference[0]:
        what = "there is no reference before the first pose"
        raise InputError(what, where=points.where(0, "kind"), remedy="Measure the reference pose first.")
    if not np.any(~reference):
        raise InputError("there are references alone", where=points.source, remedy="Add rows of the kind `pose`.")
    loaded = rows[np.any(points.wrenches[rows] != 0.0, axis=1)]
    if loaded.size:
        what = "a reference has a load, and would take its deflection for thermal"
        raise InputError(what, where=points.where(int(loaded[0])), remedy="Measure references without load.")
    moved = np.abs(points.configurations[rows] - points.configurations[rows[0]]).max(axis=1) > 1e-9
    if moved.any():
        what = "the reference pose differs from the first one"
        raise InputError(what, where=points.where(int(rows[np.argmax(moved)])), remedy="Use one reference pose.")
