"""What was measured at loaded points, by the kind of quantity that the columns of a table hold."""

from collections.abc import Callable

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.recordings.pose_columns import read_measured, read_turn_deviations, turned
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
from expdesign.chain.recordings.spans import SPANS, read_span_deviations, read_spans
from expdesign.coordinates import Coordinates
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
POSITION_DEVIATIONS = (1e-12, 0.5)
"""m; a standard deviation of a position outside of it is in a wrong unit."""


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
    axes, readings, deviations = _marked(table, points, coordinates, order)
    if points.point is None:
        return axes, readings, deviations
    spans, stated = read_spans(table, order), read_span_deviations(table, order)
    readings, axes = np.hstack([readings, spans]), np.concatenate([axes, [6, 7]])
    seen: BoolArray = np.logical_or.reduce(np.isfinite(readings), axis=0)
    if (stated is None) != (deviations is None) and seen[:-2].any():
        what = "standard deviations of positions or of distances are missing where the others are stated"
        raise InputError(what, where=table.where(), remedy="State both, or none to have them estimated.")
    if stated is None:
        return axes[seen], readings[:, seen], None
    none = np.full((len(readings), len(axes) - 2), np.nan)
    both = np.hstack([none if deviations is None else deviations, stated])
    return axes[seen], readings[:, seen], both[:, seen]


def _marked(table: Table, points: LoadedPoints, coordinates: Coordinates, order: IntArray) -> Measured:
    positions, deviations = read_positions(table, coordinates, order), read_position_deviations(table, order)
    if points.aim is None:
        return np.arange(3), positions, deviations
    rotations = turned(table, order)
    stated = read_turn_deviations(table, coordinates, rotations, order)
    if (stated is None) != (deviations is None):
        what = "standard deviations of positions or of orientations are missing where the others are stated"
        raise InputError(what, where=table.where(), remedy="State both, or none to have them estimated.")
    both = None if stated is None or deviations is None else np.hstack([deviations, stated])
    return np.arange(6), np.hstack([positions, rotations]), both


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


def read_position_deviations(table: Table, order: IntArray) -> FloatArray | None:
    """Standard deviations of the positions (m), NaN where no coordinate was read, shape (N, 3); None without any."""
    if not any(table.has(name) for name in POSITION_DEVIATION):
        return None
    deviations = table.numbers_where_filled(POSITION_DEVIATION)[order]
    missing = np.isfinite(table.numbers_where_filled(POSITION)[order]) & ~np.isfinite(deviations)
    remedy = "Fill it in, or leave the columns of standard deviations out to have them estimated."
    table.refuse(missing, POSITION_DEVIATION, "the standard deviation is missing", remedy, order)
    wrong = (deviations < POSITION_DEVIATIONS[0]) | (deviations > POSITION_DEVIATIONS[1])
    what = "{:g} cannot be the standard deviation of a position in m"
    table.refuse(wrong, POSITION_DEVIATION, what, "It is positive; check the unit.", order, deviations)
    return deviations


def _largest(coordinates: Coordinates, axes: IntArray) -> FloatArray:
    return np.where(axes < coordinates.translations, LARGEST_DEFLECTION, LARGEST_ROTATION)


READERS: dict[Measurand, Callable[[Table, LoadedPoints, Coordinates, IntArray], Measured]] = {
    DEFLECTIONS: _deflections,
    POSES: _poses,
    POSITIONS: _positions,
}
