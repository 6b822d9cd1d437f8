"""What was measured at loaded points, by the kind of quantity that the columns of a table hold.

Poses of the commanded platform: which axes were measured, and whether they can be its poses. Full poses of targets on
an arm (a camera's board, a T-Mac) are positions of markers with orientations: a row of them holds `measured_x_m` ...
`measured_rz_rad` of the target in the instrument's frame, with `sx_m` ... `srz_rad`; rotations and their deviations are
about the instrument's axes. Where no column `marker` names the target it is `tool`. Positions and poses may stand in
one file, row by row.

Readings along one line: `distance_m` is the distance of a row's marker from a fixed point of unknown place, named by
`point` (ball bar, draw wire). `gauge_m` is how far it is along `along_x, along_y, along_z` (in O) from a zero that is
not known and belongs to the gauge, also named by `point`. Standard deviations are `sdistance_m` and `sgauge_m`.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.recordings.recordings import (
    ALONG,
    DEFLECTIONS,
    POINT,
    POSES,
    POSITION,
    POSITION_DEVIATION,
    POSITIONS,
    SPAN_DEVIATIONS,
    SPANS,
    LoadedPoints,
    Measurand,
    Recordings,
    measured_names,
)
from expdesign.coordinates import SPATIAL, Coordinates
from expdesign.errors import InputError
from expdesign.io.table import Table
from expdesign.mechanics.robots.orientation import rotations_of
from expdesign.mechanics.robots.robot import Robot

FARTHEST = 0.1
"""m or rad; a measured pose farther from its command is in another unit or frame."""
FARTHEST_POSITION = 1e4
"""m; no instrument of this kind sees a position farther away."""
LONGEST = 1e3
"""m; no bar, wire or gauge is longer."""
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
        raise table.fault(what, remedy="`kind` says that this is a table of measured poses.")
    for name in (*coordinates.deflection, *POSITION):
        if table.has(name):
            what = f"there is `{name}` together with the measured poses {names[axes[0]]} ..."
            raise table.fault(what, column=name, remedy="One file holds one of them; take one out.")
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
    columns = {name: table.text(name) for name in (*POSITION, *POSITION_DEVIATION, "marker")}
    posed = np.any([table.text(name) != "" for name in _PLACES], axis=0)
    positions = np.any([columns[name] != "" for name in POSITION], axis=0)
    if (posed & positions).any():
        row = int(np.argmax(posed & positions))
        remedy = "Give a row of its own to each; they may share `series`."
        raise table.fault("the row has a position and a pose", row, POSITION[0], remedy=remedy)
    for name, place, deviation, stated in zip(
        POSITION, _PLACES, POSITION_DEVIATION, SPATIAL.deviation[:3], strict=True
    ):
        columns[name] = np.where(posed, table.text(place), columns[name])
        columns[deviation] = np.where(posed, table.text(stated), columns[deviation])
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
        raise table.fault(what, row, TURNS[int(np.argmin(seen[row]))], remedy="Fill it in.")
    large = np.abs(np.nan_to_num(angles)) > 2.0 * np.pi
    table.refuse(large, TURNS, "{:g} cannot be an angle in rad", "Check the unit.", values=angles)
    return rotations_of(np.nan_to_num(angles))[order] if seen.any() else None


def turned(table: Table, order: IntArray) -> FloatArray:
    """0 where an orientation was measured and NaN elsewhere, shape (N, 3)."""
    return np.where(np.isfinite(table.numbers_where_filled(TURNS))[order], 0.0, np.nan)


def read_fixed(table: Table, order: IntArray) -> tuple[IntArray | None, tuple[str, ...], FloatArray | None]:
    """Index of every row's fixed point or gauge (N,), their names, and unit vectors along gauges (N, 3), 0 elsewhere.

    None, () and None where the table has neither. Raises an `InputError` where a direction or a name is missing, or one
    name is of a point and of a gauge.
    """
    seen = table.numbers_where_filled(SPANS) if any(table.has(name) for name in SPANS) else None
    stated = any(table.has(name) for name in (POINT, *ALONG))
    if seen is None and not stated:
        return None, (), None
    along = np.nan_to_num(table.numbers_where_filled(ALONG))
    length = np.linalg.norm(along, axis=1)
    gauged = length > 1e-6
    if seen is not None:
        _require_directions(table, np.isfinite(seen), gauged)
    names = table.text(POINT)
    names = np.where(names == "", np.where(gauged, "gauge", "point"), names)
    for name in np.unique(names.astype(str)):
        kinds = gauged[names == name]
        if kinds.any() and not kinds.all():
            where = table.where(int(np.flatnonzero(names == name)[int(np.argmax(kinds))]), POINT)
            what = f"`{name}` is a gauge here and a fixed point in another row"
            raise InputError(what, where=where, remedy="Name them differently.")
    fixed, index = np.unique(names.astype(str), return_inverse=True)
    along = np.where(gauged[:, None], along / np.where(gauged, length, 1.0)[:, None], 0.0)
    point: IntArray = index[order].astype(np.int64)
    return point, tuple(str(name) for name in fixed), along[order]


def _require_directions(table: Table, seen: BoolArray, gauged: BoolArray) -> None:
    undirected, both = seen[:, 1] & ~gauged, seen[:, 0] & gauged
    table.refuse(undirected, ALONG[:1], "a gauge has no direction", f"Fill {', '.join(ALONG)} in (in O).")
    what = "the row has a distance and the direction of a gauge"
    table.refuse(both, SPANS[:1], what, "Give a row of its own to each.")


def read_spans(table: Table, order: IntArray) -> FloatArray:
    """Distances and readings of gauges (m), NaN where none was read, shape (N, 2)."""
    spans = table.numbers_where_filled(SPANS)
    wrong = (np.abs(np.nan_to_num(spans)) > LONGEST) | (np.nan_to_num(spans, nan=1.0)[:, :1] <= 0.0) * [True, False]
    if wrong.any():
        row, column = (int(i) for i in np.argwhere(wrong)[0])
        what = f"{spans[row, column]:g} cannot be a {('distance', 'reading of a gauge')[column]} in m"
        raise table.fault(what, row, SPANS[column], remedy="Check sign and unit.")
    return spans[order]


Measured = tuple[IntArray, FloatArray, FloatArray | None]
"""Indices of the measured components (k,), readings (N, k) and their standard deviations (N, k), where stated."""
LARGEST_DEFLECTION = 0.1
"""m; a larger "deflection" is a wrong unit or an absolute pose."""
LARGEST_ROTATION = 0.2
"""rad; likewise."""
SMALLEST_DEVIATION = 1e-18
"""m, rad; no instrument has a smaller one."""


@dataclass(frozen=True)
class ReadingBlock:
    """Readings of one kind, of which a row may have some and lack others.

    Attributes:
        axes: their places among the components of a position.
        names, deviations: their columns, and those of their standard deviations.
        noun, plural: what one of them is, and what they are.
        least, largest: a standard deviation (m, rad) beyond these is in a wrong unit.
    """

    axes: tuple[int, ...]
    names: tuple[str, ...]
    deviations: tuple[str, ...]
    noun: str
    plural: str
    least: float
    largest: float

    def deviations_in(self, table: Table, order: IntArray) -> FloatArray | None:
        """Standard deviations in the order of the sequence (N, k), NaN where nothing was read; None without any."""
        if not any(table.has(name) for name in self.deviations):
            return None
        seen = np.isfinite(table.numbers_where_filled(self.names))[order]
        deviations = table.numbers_where_filled(self.deviations)[order]
        remedy = "Fill it in, or leave the columns of standard deviations out to have them estimated."
        missing = seen & ~np.isfinite(deviations)
        table.refuse(missing, self.deviations, "the standard deviation is missing", remedy, order)
        wrong = np.isfinite(deviations) & ~((deviations >= self.least) & (deviations <= self.largest))
        what = f"{{:g}} is not one: a standard deviation of {self.noun} is positive and below {self.largest:g}"
        table.refuse(wrong, self.deviations, what, "Correct it, or check the unit.", order, deviations)
        return np.where(seen, deviations, np.nan)


POSITION_BLOCK = ReadingBlock((0, 1, 2), POSITION, POSITION_DEVIATION, "a position (m)", "positions", 1e-12, 0.5)
TURN_BLOCK = ReadingBlock((3, 4, 5), TURNS, SPATIAL.deviation[3:], "an orientation (rad)", "orientations", 1e-300, 1.0)
SPAN_BLOCK = ReadingBlock((6, 7), SPANS, SPAN_DEVIATIONS, "a distance (m)", "distances", 1e-300, 1.0)


def with_readings(table: Table, points: LoadedPoints, coordinates: Coordinates, order: IntArray) -> Recordings:
    """Points of a table with what was measured there, its rows taken in an order (N,)."""
    axes, readings, deviations = READERS[points.measurand](table, points, coordinates, order)
    test = read_test_rows(table, order)
    return Recordings(**vars(points), axes=axes, deflections=readings, deviations=deviations, test=test)


def read_deflections(table: Table, coordinates: Coordinates, order: IntArray) -> tuple[IntArray, FloatArray]:
    """Indices of the measured components (k,) and the deflections (m, rad) in the order of the sequence (N, k)."""
    axes = np.array([i for i, name in enumerate(coordinates.deflection) if table.has(name)], dtype=np.int64)
    if axes.size == 0:
        if table.has("px_m") or table.has("marker"):
            what = "recordings of marker positions are not supported for this kind of robot"
            raise table.fault(what, remedy="Convert them to deflections.")
        columns = ", ".join(coordinates.deflection)
        raise table.fault("there is no measured column", remedy=f"Fill in at least one of {columns}.")
    if table.has("px_m"):
        what = f"there are marker positions together with deflections {coordinates.deflection[axes[0]]} ..."
        raise table.fault(what, column="px_m", remedy="One file holds one of them; take one out.")
    names = tuple(coordinates.deflection[i] for i in axes)
    deflections = table.numbers(names)[order]
    remedy = "Check the unit (m, rad), and that it is not an absolute pose."
    for column, largest in enumerate(_largest(coordinates, axes)):
        what = f"{{:g}} cannot be a deflection (the largest taken for one is {largest:g})"
        values = deflections[:, column]
        table.refuse(np.abs(values) > largest, (names[column],), what, remedy, order, values)
    return axes, deflections


def read_deviations(table: Table, coordinates: Coordinates, axes: IntArray, order: IntArray) -> FloatArray | None:
    """Standard deviations of the measured components (m, rad) (N, k), or None where the file states none."""
    names = tuple(coordinates.deviation[i] for i in axes)
    if not any(table.has(name) for name in names):
        return None
    deviations = table.numbers(names)[order]
    unit, largest = "Check the unit (m, rad).", _largest(coordinates, axes)
    for wrong, what, remedy in (
        (deviations <= 0.0, "a standard deviation must be positive, not {:g}", "Correct it."),
        (deviations < SMALLEST_DEVIATION, "{:g} is smaller than the standard deviation of any instrument", unit),
        (deviations > largest, "{:g} cannot be the standard deviation of a deflection", unit),
    ):
        table.refuse(wrong, names, what, remedy, order, deviations)
    return deviations


def read_test_rows(table: Table, order: IntArray) -> BoolArray:
    """Rows that must not be fitted, in the order of the sequence, shape (N,)."""
    if not table.has("split"):
        return np.zeros(len(table), dtype=bool)
    test: BoolArray = (table.words("split", ("train", "test", ""), "`{}` is neither `train` nor `test`") == "test")[
        order
    ]
    return test


def _deflections(table: Table, points: LoadedPoints, coordinates: Coordinates, order: IntArray) -> Measured:
    axes, readings = read_deflections(table, coordinates, order)
    return axes, readings, read_deviations(table, coordinates, axes, order)


def _poses(table: Table, points: LoadedPoints, coordinates: Coordinates, order: IntArray) -> Measured:
    axes, readings = read_measured(table, points, coordinates, order)
    return axes, readings, read_deviations(table, coordinates, axes, order)


def _positions(table: Table, points: LoadedPoints, coordinates: Coordinates, order: IntArray) -> Measured:
    parts = [(POSITION_BLOCK, read_positions(table, coordinates, order))]
    if points.aim is not None:
        parts.append((TURN_BLOCK, turned(table, order)))
    if points.point is not None:
        parts.append((SPAN_BLOCK, read_spans(table, order)))
        parts = [part for part in parts if np.isfinite(part[1]).any()]
    stated = [block.deviations_in(table, order) for block, _ in parts]
    if any(each is None for each in stated) and any(each is not None for each in stated):
        kinds = " or of ".join(block.plural for block, _ in parts)
        what = f"standard deviations of {kinds} are missing where the others are stated"
        raise table.fault(what, remedy="State all, or none to have them estimated.")
    axes = np.concatenate([block.axes for block, _ in parts]).astype(np.int64)
    readings = np.hstack([values for _, values in parts])
    # Distances may stand alone; of positions and orientations all components are kept.
    kept = np.logical_or.reduce(np.isfinite(readings), axis=0) | (points.point is None)
    known = [each for each in stated if each is not None]
    return axes[kept], readings[:, kept], np.hstack(known)[:, kept] if known else None


def read_positions(table: Table, coordinates: Coordinates, order: IntArray) -> FloatArray:
    """Measured positions (m) in the order of the sequence, NaN where a coordinate was not read, shape (N, 3)."""
    for name in coordinates.deflection:
        if table.has(name):
            what = f"there are marker positions together with deflections {name} ..."
            raise table.fault(what, column=name, remedy="One file holds one of them; take one out.")
    positions = table.numbers_where_filled(POSITION)[order]
    seen = np.isfinite(np.hstack([positions, table.numbers_where_filled(SPANS)[order]]))
    empty = np.logical_not(seen.any(axis=1, keepdims=True))
    table.refuse(empty, POSITION, "no coordinate was measured", "Fill one in, or remove the row.", order)
    far = np.abs(np.nan_to_num(positions)) > FARTHEST_POSITION
    table.refuse(far, POSITION, "{:g} cannot be a position in m", "Check the unit.", order, positions)
    return positions


def _largest(coordinates: Coordinates, axes: IntArray) -> FloatArray:
    return np.where(axes < coordinates.translations, LARGEST_DEFLECTION, LARGEST_ROTATION)


READERS: dict[Measurand, Callable[[Table, LoadedPoints, Coordinates, IntArray], Measured]] = {
    DEFLECTIONS: _deflections,
    POSES: _poses,
    POSITIONS: _positions,
}
