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

from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.recordings.recordings import (
    ALONG,
    POINT,
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

FARTHEST = 0.1
"""m or rad; a measured pose farther from its command is in another unit or frame."""
COMMON = 0.01
"""m or rad; a larger difference from the command that all rows share, to within a tenth of it, is one of frames."""
_UNITS = {"m": (("mm", 1e3), ("µm", 1e6)), "rad": (("degrees", np.degrees(1.0)), ("mrad", 1e3))}
KINDS = ("reference", "pose")


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


def with_targets(table: Table, *, jointed: bool) -> Table:
    """The table with the places of measured poses under the columns of positions where the robot is `jointed`.

    Raises:
        InputError: a row has both, or is of an unknown kind.
    """
    if not jointed or not any(table.has(name) for name in _PLACES):
        return table
    if table.has("kind"):
        table.words("kind", _KINDS, "`{}` is neither `pose` nor `position`")
    columns = {name: table.text(name) for name in (*POSITION, *POSITION_DEVIATION, "marker")}
    posed = np.any([table.text(name) != "" for name in _PLACES], axis=0)
    positions = np.any([columns[name] != "" for name in POSITION], axis=0)
    remedy = "Give a row of its own to each; they may share `series`."
    table.refuse(posed & positions, POSITION[:1], "the row has a position and a pose", remedy)
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


def read_aims(table: Table) -> FloatArray | None:
    """Angles (rad) of measured orientations of targets in the instrument's axes (N, 3), 0 where none was measured.

    None where no orientations are read. Raises an `InputError` where an angle is missing or in degrees.
    """
    if not any(table.has(name) for name in TURNS):
        return None
    angles = TURN_BLOCK.readings(table)
    seen = np.isfinite(angles)
    partly = seen.any(axis=1, keepdims=True) & ~seen
    table.refuse(partly, TURNS, "an orientation has three angles", "Fill it in.")
    return np.nan_to_num(angles) if seen.any() else None


def read_fixed(table: Table) -> tuple[IntArray | None, tuple[str, ...], FloatArray | None]:
    """Index of every row's fixed point or gauge (N,), their names, and unit vectors along gauges (N, 3), 0 elsewhere.

    None, () and None where the table has neither. Raises an `InputError` where a direction or a name is missing, or one
    name is of a point and of a gauge.
    """
    if not any(table.has(name) for name in (*SPANS, POINT, *ALONG)):
        return None, (), None
    along = np.nan_to_num(table.numbers_where_filled(ALONG))
    length = np.linalg.norm(along, axis=1)
    gauged = length > 1e-6
    distance, gauge = SPAN_BLOCK.readings(table).T
    what = f"{{:g}} cannot be {SPAN_BLOCK.noun}"
    table.refuse(distance <= 0.0, SPANS[:1], what, SPAN_BLOCK.remedy, distance)
    remedy = f"Fill {', '.join(ALONG)} in (in O)."
    table.refuse(np.isfinite(gauge) & ~gauged, ALONG[:1], "a gauge has no direction", remedy)
    what = "the row has a distance and the direction of a gauge"
    table.refuse(np.isfinite(distance) & gauged, SPANS[:1], what, "Give a row of its own to each.")
    names = table.text(POINT)
    names = np.where(names == "", np.where(gauged, "gauge", "point"), names).astype(str)
    fixed, index = np.unique(names, return_inverse=True)
    both = gauged & (np.bincount(index, ~gauged)[index] > 0)
    what = "`{}` is a gauge here and a fixed point in another row"
    table.refuse(both, (POINT,), what, "Name them differently.", names)
    along = np.where(gauged[:, None], along / np.where(gauged, length, 1.0)[:, None], 0.0)
    return index.astype(np.int64), tuple(str(name) for name in fixed), along


@dataclass(frozen=True)
class ReadingBlock:
    """Readings of one kind, some of which a table may lack.

    Attributes:
        axes: their places among the components of a reading.
        names, deviations: their columns, and those of their standard deviations.
        noun, plural: what one of them is, and what they are.
        largest: a reading (m, rad) beyond it is in a wrong unit; one for all, or one for each.
        least, widest: the same of standard deviations.
        partly: whether a row may have some and lack others.
        remedy: what to do where a reading cannot be right.
    """

    axes: tuple[int, ...]
    names: tuple[str, ...]
    deviations: tuple[str, ...]
    noun: str
    plural: str
    largest: tuple[float, ...]
    least: float
    widest: tuple[float, ...]
    partly: bool = True
    remedy: str = "Check sign and unit."

    def readings(self, table: Table) -> FloatArray:
        """Readings (N, k), NaN where nothing was read.

        Raises:
            InputError: a cell is empty that may not be, holds no number, or one that cannot be right.
        """
        values = table.numbers_where_filled(self.names)
        if not self.partly:
            table.numbers(tuple(name for name in self.names if table.has(name)))
        what = f"{{:g}} cannot be {self.noun}"
        table.refuse(np.abs(np.nan_to_num(values)) > self.largest, self.names, what, self.remedy, values)
        return values

    def deviations_in(self, table: Table, seen: BoolArray) -> FloatArray | None:
        """Standard deviations (N, k) of what was seen (N, k), NaN elsewhere; None where the table states none of it.

        Raises:
            InputError: one is missing, or cannot be right.
        """
        stated = [name for name, read in zip(self.deviations, seen.T, strict=True) if read.any()]
        if not any(table.has(name) for name in stated):
            return None
        values = np.where(seen, table.numbers_where_filled(self.deviations), np.nan)
        remedy = "Fill it in, or leave the columns of standard deviations out to have them estimated."
        table.refuse(seen & np.isnan(values), self.deviations, "the standard deviation is missing", remedy)
        wrong = seen & ~((values >= self.least) & (values <= self.widest))
        what = f"{{:g}} cannot be the standard deviation of {self.noun}: it must be positive and below "
        for column, widest in enumerate(np.broadcast_to(self.widest, len(self.names))):
            own = self.deviations[column : column + 1]
            table.refuse(wrong[:, column], own, f"{what}{widest:g}", "Check the unit (m, rad).", values[:, column])
        return values


POSITION_BLOCK = ReadingBlock(
    (0, 1, 2), POSITION, POSITION_DEVIATION, "a position in m", "positions", (1e4,), 1e-12, (0.5,)
)
TURN_BLOCK = ReadingBlock(
    (3, 4, 5), TURNS, SPATIAL.deviation[3:], "an angle in rad", "orientations", (2.0 * np.pi,), 1e-300, (1.0,)
)
SPAN_BLOCK = ReadingBlock((6, 7), SPANS, SPAN_DEVIATIONS, "a distance in m", "distances", (1e3,), 1e-300, (1.0,))
"""No instrument of these kinds sees a position farther away, and no bar, wire or gauge is longer."""


def platform_block(names: tuple[str, ...], coordinates: Coordinates, *, absolute: bool) -> ReadingBlock:
    """Readings of a platform: its deflections, or its `absolute` poses.

    A larger "deflection" is a wrong unit or an absolute pose, and no instrument has a smaller standard deviation.
    """
    largest = (0.1,) * coordinates.translations + (0.2,) * coordinates.rotations
    far, noun = ((np.inf,), "a pose") if absolute else (largest, "a deflection")
    remedy = "Check the unit (m, rad), and that it is not an absolute pose."
    axes = tuple(range(coordinates.n))
    return ReadingBlock(axes, names, coordinates.deviation, noun, f"{noun}s", far, 1e-18, largest, False, remedy)


def with_readings(table: Table, points: LoadedPoints, coordinates: Coordinates) -> Recordings:
    """Points of a table with what was measured there, in the order of its rows.

    Raises:
        InputError: nothing was measured, or two kinds of quantities, or what cannot be right.
    """
    spans = points.point is not None
    axes, readings, deviations = read_measured(table, points.measurand, coordinates, spans=spans)
    if points.poses:
        if table.has("kind"):
            table.words("kind", KINDS, "`{}` is neither `reference` nor `pose`")
        require_commanded_coordinates(points, readings, axes, coordinates)
    test = read_test_rows(table)
    return Recordings(**vars(points), axes=axes, deflections=readings, deviations=deviations, test=test)


def read_measured(
    table: Table, measurand: Measurand, coordinates: Coordinates, *, spans: bool = False
) -> tuple[IntArray, FloatArray, FloatArray | None]:
    """Indices of the measured components (k,), readings (N, k) and their standard deviations (N, k), where stated.

    Args:
        table: the recordings.
        measurand: what they are of.
        coordinates: of the robot.
        spans: whether markers may have distances and readings of gauges.

    Raises:
        InputError: as `with_readings`.
    """
    names, positions = measurand.columns(coordinates), measurand is POSITIONS
    present = [name for name in names if table.has(name)]
    if not present and not positions:
        raise table.fault("there is no measured column", remedy=f"Fill in at least one of {', '.join(names)}.")
    for name in (*coordinates.deflection, *POSITION):
        if name not in names and table.has(name):
            what = f"there is `{name}` together with {measurand.name} {', '.join(present[:1])} ..."
            raise table.fault(what, column=name, remedy="One file holds one of them; take one out.")
    blocks = [platform_block(names, coordinates, absolute=measurand.absolute)]
    if positions:
        blocks = [POSITION_BLOCK, TURN_BLOCK, *([SPAN_BLOCK] if spans else [])]
    parts = [(block, block.readings(table)) for block in blocks]
    if positions:
        empty = np.isnan(np.hstack([parts[0][1], table.numbers_where_filled(SPANS)])).all(axis=1)
        table.refuse(empty, POSITION, "no coordinate was measured", "Fill one in, or remove the row.")
    parts = [(block, values) for block, values in parts if np.isfinite(values).any()]
    stated = [block.deviations_in(table, np.isfinite(values)) for block, values in parts]
    known = [each for each in stated if each is not None]
    if 0 < len(known) < len(stated):
        kinds = " or of ".join(block.plural for block, _ in parts)
        what = f"standard deviations of {kinds} are missing where the others are stated"
        raise table.fault(what, remedy="State all, or none to have them estimated.")
    axes = np.concatenate([block.axes for block, _ in parts]).astype(np.int64)
    # Rotations of targets are counted from what was measured.
    readings = np.hstack([0.0 * values if block is TURN_BLOCK else values for block, values in parts])
    # Distances may stand alone; of positions and orientations all components are kept.
    kept = np.isfinite(readings).any(axis=0) | (positions and not spans)
    return axes[kept], readings[:, kept], np.hstack(known)[:, kept] if known else None


def read_test_rows(table: Table) -> BoolArray:
    """Rows that must not be fitted, shape (N,)."""
    rows: BoolArray = table.words("split", ("train", "test", ""), "`{}` is neither `train` nor `test`") == "test"
    return rows
