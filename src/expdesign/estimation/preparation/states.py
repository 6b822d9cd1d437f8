"""Which set of points belongs to which row of a plan.

A column `points` of the plan names the set (a group of the list, or a file without its ending) of a row, and
`reference_points` that of its unloaded state. Without these columns names say it: `loaded-3`, `row 3`, `3` belong to
the row with the sequence number 3; `unloaded-2`, `reference-2` to the unloaded state of series 2. Where the plan has
rows without load, as a laboratory sheet has, the points of such a row are the reference of the rows after it in its
series.
"""

import re
from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray
from expdesign.chain.recordings.recordings import order_in_time
from expdesign.errors import InputError
from expdesign.estimation.preparation.point_lists import PointSet
from expdesign.io.table import Table

_LOADED = re.compile(r"(?:loaded|load|row|measurement|m)?[ _-]*0*(\d+)", re.IGNORECASE)
_UNLOADED = re.compile(r"(?:unloaded|reference|ref|zero|u)[ _-]*(?:series)?[ _-]*0*(\d+)", re.IGNORECASE)


@dataclass(frozen=True)
class RecordedState:
    """A row of the table with its points, loaded and unloaded."""

    row: int
    loaded: PointSet
    reference: PointSet


def matched(table: Table, sets: list[PointSet], unloaded: BoolArray) -> list[RecordedState]:
    """The loaded rows for which there are points, in the order of the sequence.

    Args:
        table: plan with `sequence` and `series`.
        sets: all sets of points.
        unloaded: rows without load, shape (N,).

    Raises:
        InputError: two sets have one name, a set belongs to no row, or a row has no reference.
    """
    named: dict[str, PointSet] = {}
    for item in sets:
        if item.name in named:
            what = f"the set of points `{item.name}` is also in {named[item.name].source}"
            raise InputError(what, where=item.source, remedy="Give every state a name of its own.")
        named[item.name] = item
    sequence, series = table.integers("sequence"), table.integers("series")
    by_row = _by_number(named, _LOADED)
    by_series = _by_number(named, _UNLOADED)
    used: set[str] = set()
    states: list[RecordedState] = []
    last: dict[int, PointSet] = {}
    for row in order_in_time(table):
        own = _in_column(table, "points", int(row), named) or by_row.get(int(sequence[row]))
        number = int(series[row])
        if unloaded[row]:
            if own is not None:
                last[number] = own
                used.add(own.name)
            continue
        if own is None:
            continue
        reference = _in_column(table, "reference_points", int(row), named) or last.get(number) or by_series.get(number)
        if reference is None:
            raise _no_reference(table, int(row), own, unloaded)
        used |= {own.name, reference.name}
        states.append(RecordedState(int(row), own, reference))
    left = [item for item in sets if item.name not in used]
    if left or not states:
        names = ", ".join(f"`{item.name}`" for item in left[:4])
        what = f"no row of the plan is measured by the sets of points {names}" if left else "no points match the plan"
        remedy = "Name sets `loaded-SEQUENCE` and `unloaded-SERIES`, or write their names into a column `points`."
        raise InputError(what, where=left[0].source if left else table.source, remedy=remedy)
    return states


def _no_reference(table: Table, row: int, own: PointSet, unloaded: BoolArray) -> InputError:
    """That a row has no unloaded points; where the plan has a row without load before it, in the words of the sets."""
    sequence, series = table.integers("sequence"), table.integers("series")
    number = int(series[row])
    what = f"there are no unloaded points of series {number}"
    remedy = f"Name a set `unloaded-{number}`, or write its name into a column `reference_points`."
    before = np.flatnonzero(unloaded & (series == number) & (sequence < sequence[row]))
    if before.size:
        missing = int(sequence[before].max())
        name = re.sub(r"\d+", str(missing), own.name)
        what = f"there are no points of row {missing}, in which the platform of series {number} carries no load"
        remedy = f"Add the set `{name}`: row {int(sequence[row])} (`{own.name}`) is measured against it."
    return InputError(what, where=table.where(row), remedy=remedy)


def _by_number(named: dict[str, PointSet], pattern: re.Pattern[str]) -> dict[int, PointSet]:
    found: dict[int, PointSet] = {}
    for name, item in named.items():
        match = pattern.fullmatch(name.strip())
        if match is None:
            continue
        number = int(match.group(1))
        if number in found:
            what = f"the sets of points `{found[number].name}` and `{name}` both have the number {number}"
            raise InputError(what, where=item.source, remedy="Give every state a number of its own.")
        found[number] = item
    return found


def _in_column(table: Table, column: str, row: int, named: dict[str, PointSet]) -> PointSet | None:
    name = str(table.text(column)[row])
    if name == "":
        return None
    if name not in named:
        known = ", ".join(sorted(named)[:6])
        raise table.fault(f"there is no set of points `{name}`", row, column, remedy=f"There are {known}.")
    return named[name]
