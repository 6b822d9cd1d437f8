"""The columns of measured poses: which axes were measured, and whether they can be poses of the commanded platform.

Measured full poses of targets on an arm (a camera's board, a T-Mac) as positions of markers with orientations.

A row of measured poses holds `measured_x_m` ... `measured_rz_rad` of the target in the instrument's frame, with `sx_m`
... `srz_rad`; rotations and their deviations are about the instrument's axes. Where no column `marker` names the target
it is `tool`. Positions and poses may stand in one file, row by row.
"""

from dataclasses import replace

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.recordings.recordings import POSITION, POSITION_DEVIATION, LoadedPoints, measured_names
from expdesign.coordinates import SPATIAL, Coordinates
from expdesign.errors import InputError
from expdesign.io.table import Table
from expdesign.mechanics.robots.orientation import rotations_of
from expdesign.mechanics.robots.robot import Robot

FARTHEST = 0.1
"""m or rad; a measured pose farther from its command is in another unit or frame."""
COMMON = 0.01
"""m or rad; a larger difference from the command that all rows share, to within a tenth of it, is one of frames."""
_UNITS = {"m": (("mm", 1e3), ("µm", 1e6)), "rad": (("degrees", np.degrees(1.0)), ("mrad", 1e3))}
KINDS = ("reference", "pose")


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
    "argument `frames=unknown` for what is left."
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


TARGET = "tool"
"""Name of a target that has none."""
_LARGEST = 2.0 * np.pi
_PLACES, TURNS = measured_names(SPATIAL)[:3], measured_names(SPATIAL)[3:]
_KINDS = ("pose", "position", "reference", "")


def with_targets(table: Table, robot: Robot) -> Table:
    """The table with the places of measured poses under the columns of positions; others stay as they are.

    Raises:
        InputError: a row has both, or is of an unknown kind.
    """
    if not robot.jointed or not any(table.has(name) for name in _PLACES):
        return table
    if table.has("kind"):
        table.words("kind", _KINDS, "`{}` is neither `pose` nor `position`")
    columns = {name: _cells(table, name) for name in (*POSITION, *POSITION_DEVIATION, "marker")}
    posed = np.any([_cells(table, name) != "" for name in _PLACES], axis=0)
    positions = np.any([columns[name] != "" for name in POSITION], axis=0)
    if (posed & positions).any():
        row = int(np.argmax(posed & positions))
        remedy = "Give a row of its own to each; they may share `series`."
        raise InputError("the row has a position and a pose", where=table.where(row, POSITION[0]), remedy=remedy)
    for name, place, deviation, stated in zip(
        POSITION, _PLACES, POSITION_DEVIATION, SPATIAL.deviation[:3], strict=True
    ):
        columns[name] = np.where(posed, _cells(table, place), columns[name])
        columns[deviation] = np.where(posed, _cells(table, stated), columns[deviation])
    columns["marker"] = np.where(posed & (columns["marker"] == ""), TARGET, columns["marker"])
    kept = {name: cells for name, cells in columns.items() if (cells != "").any()}
    frame = table.frame.drop(columns=[name for name in _PLACES if table.has(name)]).assign(**kept)
    written = {name: table.written.get(place, place) for name, place in zip(POSITION, _PLACES, strict=True)}
    return replace(table, frame=frame, written=table.written | ({} if positions.any() else written))


def read_aims(table: Table, order: IntArray) -> FloatArray | None:
    """Measured orientations A of targets in the instrument's axes (N, 3, 3), the identity where none was measured.

    None where no orientations are read. Raises an `InputError` where an angle is missing or in degrees.
    """
    if not any(table.has(name) for name in TURNS):
        return None
    angles = table.numbers_where_filled(TURNS)
    seen = np.isfinite(angles)
    partly = seen.any(axis=1) & ~seen.all(axis=1)
    if partly.any():
        row = int(np.argmax(partly))
        what = "an orientation has three angles"
        raise InputError(what, where=table.where(row, TURNS[int(np.argmin(seen[row]))]), remedy="Fill it in.")
    large = np.abs(np.nan_to_num(angles)) > _LARGEST
    table.refuse(large, TURNS, "{:g} cannot be an angle in rad", "Check the unit.", values=angles)
    return rotations_of(np.nan_to_num(angles))[order] if seen.any() else None


def turned(table: Table, order: IntArray) -> FloatArray:
    """0 where an orientation was measured and NaN elsewhere, shape (N, 3)."""
    return np.where(np.isfinite(table.numbers_where_filled(TURNS))[order], 0.0, np.nan)


def _cells(table: Table, name: str) -> np.ndarray:
    if not table.has(name):
        return np.full(len(table), "", dtype=object)
    return table.frame[name].astype(str).str.strip().to_numpy(dtype=object)
