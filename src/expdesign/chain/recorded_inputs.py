"""What physics depends on, held at the ends of the range in which it was recorded (`Beyond.HOLDS`).

A drift is a straight line through what was recorded because nothing better is known, not because anything drifts for
ever. Beyond the recorded times and temperatures it stays where it was at the nearest end.
"""

from collections.abc import Mapping
from dataclasses import replace

import casadi as ca

from expdesign.arrays import BoolArray
from expdesign.chain.row import Row, RowData

INPUTS = {
    "elapsed": "time_in_series_s",
    "clock": "time_s",
    "warming": "temperature_change_K",
    "warmth": "temperature_degC",
}
"""Times and temperatures of a row (`Row`), by their names in files."""


Ranges = Mapping[str, tuple[float, float]]
"""Smallest and largest value by name in files; of several actuators with their numbers (`…_2`)."""


def ranges_of(rows: RowData, counts: BoolArray, symbols: Row) -> Ranges:
    """The ranges in the rows that count (N,), as the symbols of a row name their columns."""
    found = {}
    for name in INPUTS:
        values = rows.values[counts][:, symbols.columns(name)]
        for index, (low, high) in enumerate(zip(values.min(axis=0), values.max(axis=0), strict=True)):
            found[_name(name, index)] = float(low), float(high)
    return found


def held(row: Row, ranges: Ranges) -> Row:
    """The row with these inputs at the nearest values that were recorded."""
    found = {}
    for name in INPUTS:
        values = getattr(row, name)
        ends = [ranges.get(_name(name, index), (-ca.inf, ca.inf)) for index in range(values.numel())]
        found[name] = ca.vertcat(*(ca.fmin(ca.fmax(values[i], low), high) for i, (low, high) in enumerate(ends)))
    return replace(row, **found)


def _name(name: str, index: int) -> str:
    return INPUTS[name] + (f"_{index + 1}" if index else "")
