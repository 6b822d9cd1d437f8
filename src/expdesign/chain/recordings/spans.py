"""Readings along one line: distances from a fixed point (ball bar, draw wire), and gauges along a direction.

`distance_m` is the distance of a row's marker from a fixed point of unknown place, named by `point`. `gauge_m` is how
far it is along `along_x, along_y, along_z` (in O) from a zero that is not known and belongs to the gauge, also named by
`point`. Standard deviations are `sdistance_m` and `sgauge_m`.
"""

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.errors import InputError
from expdesign.io.table import Table

SPANS = ("distance_m", "gauge_m")
SPAN_DEVIATIONS = ("sdistance_m", "sgauge_m")
ALONG = ("along_x", "along_y", "along_z")
POINT = "point"
_FARTHEST = 1e3
"""m; no bar, wire or gauge is longer."""
_SHORTEST = 1e-6
"""Length of a direction below which it is none."""


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
    gauged = length > _SHORTEST
    if seen is not None:
        _require_directions(table, np.isfinite(seen), gauged)
    names = np.full(len(table), "", dtype=object)
    if table.has(POINT):
        names = table.frame[POINT].astype(str).str.strip().to_numpy(dtype=object)
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
    missing = seen[:, 1] & ~gauged
    if missing.any():
        where = table.where(int(np.argmax(missing)), ALONG[0])
        raise InputError("a gauge has no direction", where=where, remedy=f"Fill {', '.join(ALONG)} in (in O).")
    both = seen[:, 0] & gauged
    if both.any():
        where = table.where(int(np.argmax(both)), SPANS[0])
        remedy = "Give a row of its own to each."
        raise InputError("the row has a distance and the direction of a gauge", where=where, remedy=remedy)


def read_spans(table: Table, order: IntArray) -> FloatArray:
    """Distances and readings of gauges (m), NaN where none was read, shape (N, 2)."""
    spans = table.numbers_where_filled(SPANS)
    wrong = (np.abs(np.nan_to_num(spans)) > _FARTHEST) | (np.nan_to_num(spans, nan=1.0)[:, :1] <= 0.0) * [True, False]
    if wrong.any():
        row, column = (int(i) for i in np.argwhere(wrong)[0])
        what = f"{spans[row, column]:g} cannot be a {('distance', 'reading of a gauge')[column]} in m"
        raise InputError(what, where=table.where(row, SPANS[column]), remedy="Check sign and unit.")
    return spans[order]
