"""What was measured at loaded points, by the kind of quantity that the columns of a table hold."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.recordings.pose_columns import TURNS, read_measured, turned
from expdesign.chain.recordings.recordings import (
    DEFLECTIONS,
    POSES,
    POSITION,
    POSITION_DEVIATION,
    POSITIONS,
    LoadedPoints,
    Measurand,
    Recordings,
)
from expdesign.chain.recordings.spans import SPAN_DEVIATIONS, SPANS, read_spans
from expdesign.coordinates import SPATIAL, Coordinates
from expdesign.errors import InputError
from expdesign.io.table import Table

Measured = tuple[IntArray, FloatArray, FloatArray | None]
"""Indices of the measured components (k,), readings (N, k) and their standard deviations (N, k), where stated."""
LARGEST_DEFLECTION = 0.1
"""m; a larger "deflection" is a wrong unit or an absolute pose."""
LARGEST_ROTATION = 0.2
"""rad; likewise."""
SMALLEST_DEVIATION = 1e-18
"""m, rad; no instrument has a smaller one."""
FARTHEST = 1e4
"""m; no instrument of this kind sees a position farther away."""


@dataclass(frozen=True)
class Block:
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
        what = f"{{:g}} is none: a standard deviation of {self.noun} is positive and below {self.largest:g}"
        table.refuse(wrong, self.deviations, what, "Correct it, or check the unit.", order, deviations)
        return np.where(seen, deviations, np.nan)


POSITION_BLOCK = Block((0, 1, 2), POSITION, POSITION_DEVIATION, "a position (m)", "positions", 1e-12, 0.5)
TURN_BLOCK = Block((3, 4, 5), TURNS, SPATIAL.deviation[3:], "an orientation (rad)", "orientations", 1e-300, 1.0)
SPAN_BLOCK = Block((6, 7), SPANS, SPAN_DEVIATIONS, "a distance (m)", "distances", 1e-300, 1.0)


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
            raise InputError(what, where=table.where(), remedy="Convert them to deflections.")
        columns = ", ".join(coordinates.deflection)
        raise InputError(
            "there is no measured column", where=table.where(), remedy=f"Fill in at least one of {columns}."
        )
    if table.has("px_m"):
        what = f"there are marker positions beside the deflections {coordinates.deflection[axes[0]]} ..."
        raise InputError(what, where=table.where(column="px_m"), remedy="One file holds one of them; take one out.")
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
        raise InputError(what, where=table.where(), remedy="State all, or none to have them estimated.")
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
            what = f"there are marker positions beside the deflections {name} ..."
            raise InputError(what, where=table.where(column=name), remedy="One file holds one of them; take one out.")
    positions = table.numbers_where_filled(POSITION)[order]
    seen = np.isfinite(np.hstack([positions, table.numbers_where_filled(SPANS)[order]]))
    empty = np.logical_not(seen.any(axis=1, keepdims=True))
    table.refuse(empty, POSITION, "no coordinate was measured", "Fill one in, or remove the row.", order)
    far = np.abs(np.nan_to_num(positions)) > FARTHEST
    table.refuse(far, POSITION, "{:g} cannot be a position in m", "Check the unit.", order, positions)
    return positions


def _largest(coordinates: Coordinates, axes: IntArray) -> FloatArray:
    return np.where(axes < coordinates.translations, LARGEST_DEFLECTION, LARGEST_ROTATION)


READERS: dict[Measurand, Callable[[Table, LoadedPoints, Coordinates, IntArray], Measured]] = {
    DEFLECTIONS: _deflections,
    POSES: _poses,
    POSITIONS: _positions,
}
