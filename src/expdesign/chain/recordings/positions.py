"""The columns of position recordings: which marker, where it was measured, how well (file-formats.md, Recordings)."""

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.recordings.measurand import POSITION, POSITION_DEVIATION
from expdesign.chain.recordings.spans import SPANS
from expdesign.coordinates import Coordinates
from expdesign.errors import InputError
from expdesign.io.table import Table

FARTHEST = 1e4
"""m; no instrument of this kind sees farther."""
LARGEST_DEVIATION = 0.5
"""m; a larger standard deviation is a wrong unit."""
SMALLEST_DEVIATION = 1e-12


def read_markers(table: Table, order: IntArray) -> tuple[IntArray | None, tuple[str, ...]]:
    """Index of every row's marker in the order of the sequence (N,), or None, and the markers' names."""
    if not table.has("marker"):
        if table.has("px_m") or any(table.has(name) for name in SPANS):
            remedy = "Name the marker of each row (one name where there is one marker)."
            raise InputError("the column is missing", where=table.where(column="marker"), remedy=remedy)
        return None, ()
    names = table.frame["marker"].astype(str).str.strip().to_numpy()
    empty = np.flatnonzero(names == "")
    if empty.size:
        where = table.where(int(empty[0]), "marker")
        raise InputError("the marker has no name", where=where, remedy="Write its name.")
    markers, index = np.unique(names, return_inverse=True)
    chosen: IntArray = index[order].astype(np.int64)
    return chosen, tuple(str(name) for name in markers)


def read_positions(table: Table, coordinates: Coordinates, order: IntArray) -> FloatArray:
    """Measured positions (m) in the order of the sequence, NaN where a coordinate was not read, shape (N, 3)."""
    for name in coordinates.deflection:
        if table.has(name):
            what = f"there are marker positions beside the deflections {name} ..."
            raise InputError(what, where=table.where(column=name), remedy="One file holds one of them; take one out.")
    positions = table.numbers_where_filled(POSITION)[order]
    seen = np.isfinite(np.hstack([positions, table.numbers_where_filled(SPANS)[order]]))
    empty = np.flatnonzero(~seen.any(axis=1))
    if empty.size:
        where = table.where(int(order[empty[0]]), POSITION[0])
        raise InputError("no coordinate was measured", where=where, remedy="Fill one in, or remove the row.")
    wrong = np.abs(np.nan_to_num(positions)) > FARTHEST
    if wrong.any():
        row, column = (int(i) for i in np.argwhere(wrong)[0])
        where = table.where(int(order[row]), POSITION[column])
        raise InputError(f"{positions[row, column]:g} cannot be a position in m", where=where, remedy="Check the unit.")
    return positions


def read_position_deviations(table: Table, order: IntArray) -> FloatArray | None:
    """Standard deviations of the positions (m), NaN where no coordinate was read, shape (N, 3); None without any."""
    if not any(table.has(name) for name in POSITION_DEVIATION):
        return None
    deviations = table.numbers_where_filled(POSITION_DEVIATION)[order]
    missing = np.isfinite(table.numbers_where_filled(POSITION)[order]) & ~np.isfinite(deviations)
    if missing.any():
        row, column = (int(i) for i in np.argwhere(missing)[0])
        where = table.where(int(order[row]), POSITION_DEVIATION[column])
        remedy = "Fill it in, or leave the columns of standard deviations out to have them estimated."
        raise InputError("the standard deviation is missing", where=where, remedy=remedy)
    wrong = (deviations < SMALLEST_DEVIATION) | (deviations > LARGEST_DEVIATION)
    if wrong.any():
        row, column = (int(i) for i in np.argwhere(wrong)[0])
        where = table.where(int(order[row]), POSITION_DEVIATION[column])
        what = f"{deviations[row, column]:g} cannot be the standard deviation of a position in m"
        raise InputError(what, where=where, remedy="It is positive; check the unit.")
    return deviations
