"""The columns of measured poses: which axes were measured, and whether they can be poses of the commanded platform."""

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.recordings.measurand import POSITION, measured_names
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.coordinates import Coordinates
from expdesign.errors import InputError
from expdesign.io.table import Table
from expdesign.mechanics.robots.robot import Robot

FARTHEST = 0.1
"""m or rad; a measured pose farther from its command is in another unit or frame."""
COMMON = 0.01
"""m or rad; a larger difference from the command that all rows share, to within a tenth of it, is one of frames."""
_UNITS = {"m": (("mm", 1e3), ("µm", 1e6)), "rad": (("degrees", np.degrees(1.0)), ("mrad", 1e3))}
KINDS = ("reference", "pose")


def measures_poses(table: Table, robot: Robot) -> bool:
    """Whether a table is one of measured poses: by its columns `measured_x_m` ..., or by `kind` where those are due."""
    if not robot.on_legs:
        return False
    if any(table.has(name) for name in measured_names(robot.coordinates)):
        return True
    return table.has("kind") and bool(table.frame["kind"].astype(str).str.strip().isin(KINDS).all())


def read_measured(
    table: Table, points: LoadedPoints, coordinates: Coordinates, order: IntArray
) -> tuple[IntArray, FloatArray]:
    """Indices of the measured axes (k,) and the poses on them (m, rad), shape (N, k), in the order of the sequence.

    Raises:
        InputError: nothing was measured, there are deflections or positions as well, `kind` is another word, or the
            poses are in another unit or frame than the commands.
    """
    names = measured_names(coordinates)
    axes = np.array([i for i, name in enumerate(names) if table.has(name)], dtype=np.int64)
    if not axes.size:
        what = f"there is no measured column; fill in at least one of {', '.join(names)}"
        raise InputError(what, where=table.where(), remedy="`kind` says that this is a table of measured poses.")
    for name in (*coordinates.deflection, *POSITION):
        if table.has(name):
            what = f"there is `{name}` beside the measured poses {names[axes[0]]} ..."
            raise InputError(what, where=table.where(column=name), remedy="One file holds one of them; take one out.")
    if table.has("kind"):
        table.words("kind", KINDS, "`{}` is neither `reference` nor `pose`")
    poses = table.numbers(tuple(names[i] for i in axes))[order]
    require_commanded_coordinates(points, poses, axes, coordinates)
    return axes, poses


def require_commanded_coordinates(
    points: LoadedPoints, poses: FloatArray, axes: IntArray, coordinates: Coordinates
) -> None:
    """Raise an `InputError` where measured poses (N, k) on `axes` are in another unit or frame than the commands."""
    names = measured_names(coordinates)
    for column, axis in enumerate(axes):
        commands, measured = points.configurations[:, axis], poses[:, column]
        difference = measured - commands
        row = int(np.argmax(np.abs(difference)))
        unit = _other_unit(commands, measured, coordinates.pose[axis].rpartition("_")[2])
        if unit:
            what = f"the column goes with the commands as one in {unit} would"
            remedy = f"Write it in {coordinates.pose[axis].rpartition('_')[2]}."
            raise InputError(what, where=points.where(row, names[axis]), remedy=remedy)
        if abs(difference[row]) > FARTHEST:
            what = f"{measured[row]:g} is more than {FARTHEST:g} away from the commanded {commands[row]:g}"
            raise InputError(what, where=points.where(row, names[axis]), remedy=_FRAMES)
        common = float(np.median(difference))
        if len(points) > 2 and abs(common) > COMMON and np.ptp(difference) < 0.1 * abs(common):
            what = f"all rows are off by {common:.3g} from the commanded pose: another frame or another zero"
            raise InputError(what, where=points.where(row, names[axis]), remedy=_FRAMES)


_FRAMES = (
    "Measured poses are in the coordinates of the commanded ones: check the unit (m, rad), and the frames and zeros of "
    "instrument and platform; transform the poses into the robot's frame, as near as it is known, and say "
    "`--frames unknown` for what is left."
)


def _other_unit(commands: FloatArray, measured: FloatArray, unit: str) -> str | None:
    """The unit in which a column must be that is proportional to the commands, or None."""
    spread, own = commands - commands.mean(), measured - measured.mean()
    size = float(spread @ spread)
    if len(commands) < 3 or size <= 0.0:
        return None
    slope = float(spread @ own) / size
    left = float(np.linalg.norm(own - slope * spread))
    for name, factor in _UNITS[unit]:
        if abs(slope / factor - 1.0) < 0.2 and left < 0.2 * float(np.linalg.norm(own)):
            return name
    return None
