"""Which rows share the noise of one unloaded reading (file-formats.md, Recordings; theory.md 3).

A deflection is a loaded reading minus an unloaded one. Rows that are counted from one unloaded reading have its noise
in common, half of each row's variance. Which rows these are is said, the first of these that speaks, by

1. the option of a command, which overrides;
2. the column `reference`, or the rows without load of a laboratory sheet, from which its readings are counted;
3. the configuration (`shared_reference: true`: the rows of one series at one command share one).

What contradicts the statement that holds is named. Readings of poses and positions have no unloaded reading, and a
configuration says nothing of them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray, TextArray
from expdesign.chain.recordings.columns import REFERENCE
from expdesign.chain.recordings.recordings import LoadedPoints, Recordings
from expdesign.io.table import Table

Points = TypeVar("Points", bound=LoadedPoints)


@dataclass(frozen=True)
class Sharing:
    """What is said of references beside the recordings.

    Attributes:
        option: of the command; None where it is not given.
        configured: whether the rows of one series share a reference by the configuration; None without one.
        configuration: its file.
    """

    option: bool | None = None
    configured: bool | None = None
    configuration: str = ""

    @property
    def name(self) -> str:
        """Who says it, in words."""
        if self.option is not None:
            return f"argument `shared_reference={self.option}`"
        return f"`shared_reference: {'true' if self.configured else 'false'}` of {self.configuration}"


@dataclass(frozen=True)
class Contradiction:
    """Two statements on references that cannot both be right: what they say, and which holds."""

    what: str
    holds: str


def reference_names(series: Sequence[int] | IntArray) -> list[str]:
    """Names of the unloaded readings of series that share one, for the column `reference`."""
    return [f"unloaded-{number}" for number in series]


def read_references(table: Table, commands: FloatArray | None = None) -> TextArray | None:
    """Name of the unloaded reading of every row, shape (N,); None without the column.

    Args:
        table: the recordings.
        commands: of its rows, shape (N, n_q), where rows of one unloaded reading share one.

    Raises:
        InputError: rows that are counted from one unloaded reading have different commands.
    """
    if not table.has(REFERENCE):
        return None
    names: TextArray = table.text(REFERENCE).astype(str)
    if commands is None:
        return names
    _, first, index = np.unique(groups(names), return_index=True, return_inverse=True)
    differs = np.abs(commands - commands[first[index]]).max(axis=1) > 1e-9
    what = "the command differs from that of row {}, which has the same reference"
    remedy = "An unloaded reading is the reference of rows at its own command. Correct the name or the command."
    table.refuse(differs, (REFERENCE,), what, remedy, table.lines[first[index]])
    return names


def groups(references: TextArray) -> IntArray:
    """Numbers from 0, equal for rows that share a reference, shape (N,); a row without a name has its own."""
    numbers = np.unique(references, return_inverse=True)[1]
    alone = numbers.max(initial=0) + 1 + np.arange(len(references))
    found: IntArray = np.unique(np.where(references == "", alone, numbers), return_inverse=True)[1]
    return found


def sharing_rows(points: LoadedPoints) -> BoolArray:
    """Rows that share their reference with another row, shape (N,)."""
    if points.references is None:
        return np.zeros(len(points), dtype=bool)
    numbers = groups(points.references)
    several: BoolArray = np.bincount(numbers)[numbers] > 1
    return several


def reference_rows(recordings: Recordings) -> BoolArray:
    """Unloaded rows whose deflections are exactly zero: references by definition, which measure nothing; shape (N,)."""
    unloaded = (recordings.wrenches == 0.0).all(axis=1)
    rows: BoolArray = unloaded & (recordings.deflections == 0.0).all(axis=1)
    return rows


def with_references(points: Points, sharing: Sharing) -> tuple[Points, list[Contradiction]]:
    """The points with the reference of every row as it is said, and what contradicts it."""
    stated = points.references
    said = sharing.configured if sharing.option is None else sharing.option
    if said is None:
        return points, []
    if sharing.option is None and points.measurand.absolute:
        said = False
    if sharing.option:
        other = np.array(reference_names(points.series))
    elif said:
        other = _by_series_and_command(points)
    else:
        other = np.array([f"alone-{row}" for row in range(len(points))])
    if isinstance(points, Recordings):
        other = np.where(reference_rows(points), "", other)
    if stated is None:
        return replace(points, references=other), []
    chosen = other if sharing.option is not None else np.where(stated == "", other, stated)
    pair = first_disagreement(stated, other)
    if pair is None:
        return replace(points, references=chosen), []
    lines = f"rows {points.lines[pair[0]]} and {points.lines[pair[1]]}"
    if stated[pair[0]] == stated[pair[1]]:
        what = f"{lines} are counted from one unloaded reading, and by {sharing.name} from one each"
    else:
        what = f"{lines} are counted from an unloaded reading each, and by {sharing.name} from one"
    holds = "What the recordings say holds" if sharing.option is None else "The option holds"
    return replace(points, references=chosen), [Contradiction(what, f"{holds}; correct the other one.")]


def _by_series_and_command(points: LoadedPoints) -> TextArray:
    """Names of the unloaded readings of series; one for each command, as compensated targets of one series have."""
    keys = np.concatenate([points.series[:, None], np.round(points.configurations, 9)], axis=1)
    first, index = np.unique(keys, axis=0, return_index=True, return_inverse=True)[1:]
    begins = np.unique(points.series, return_index=True)[1]
    one = np.isin(first, begins)[index.ravel()]
    names = reference_names(points.series)
    return np.array([name if own else f"{name}-{n}" for name, own, n in zip(names, one, index.ravel(), strict=True)])


def first_disagreement(one: TextArray, other: TextArray) -> tuple[int, int] | None:
    """The first two rows of which one statement (N,) says that they share a reference, and the other that they do not.

    Rows without a name in one of them agree with everything.
    """
    known = np.flatnonzero((one != "") & (other != ""))
    mine, yours = groups(one[known]), groups(other[known])
    # The same partition: every number of one goes with one number of the other.
    for a, b in ((mine, yours), (yours, mine)):
        first = np.unique(a, return_index=True)[1][a]
        differs = np.flatnonzero(b != b[first])
        if differs.size:
            row = int(differs[0])
            return int(known[first[row]]), int(known[row])
    return None
