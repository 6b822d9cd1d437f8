"""What physics depends on, held at the ends of the range in which it was recorded (`Beyond.HOLDS`).

A drift is a straight line through what was recorded because nothing better is known, not because anything drifts for
ever. Beyond the recorded times and temperatures it stays where it was at the nearest end.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

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


@dataclass(frozen=True)
class RecordedInputs:
    """Ranges of times and temperatures.

    Attributes:
        ranges: smallest and largest value by name in files; of several actuators with their numbers (`…_2`).
    """

    ranges: Mapping[str, tuple[float, float]]

    @classmethod
    def of(cls, rows: RowData, counts: BoolArray, symbols: Row) -> "RecordedInputs":
        """The ranges in the rows that count (N,), as the symbols of a row name their columns."""
        found = {}
        for name in INPUTS:
            values = rows.values[counts][:, symbols.columns(name)]
            for index, (low, high) in enumerate(zip(values.min(axis=0), values.max(axis=0), strict=True)):
                found[_name(name, index)] = float(low), float(high)
        return cls(found)

    def held(self, row: Row) -> Row:
        """The row with these inputs at the nearest values that were recorded."""
        return replace(row, **{name: self._held(name, getattr(row, name)) for name in INPUTS})

    def _held(self, name: str, values: ca.SX) -> ca.SX:
        held = []
        for index in range(values.numel()):
            low, high = self.ranges.get(_name(name, index), (-ca.inf, ca.inf))
            held.append(ca.fmin(ca.fmax(values[index], low), high))
        return ca.vertcat(*held)


def _name(name: str, index: int) -> str:
    return INPUTS[name] + (f"_{index + 1}" if index else "")
