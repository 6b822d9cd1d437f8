"""What a kind is built from in one campaign: the machine, its loads, a chosen member and drawn values."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ..campaigns import Campaign
from ..hexapods import Array

Machine = TypeVar("Machine")


@dataclass(frozen=True)
class Setting(Generic[Machine]):
    """`member`: index of the leg or joint, `most`: its largest force or torque (N, N m), `stretch`: what it yields
    under that (m, rad), `drawn`: values of the kind's ranges.
    """

    machine: Machine
    campaign: Campaign
    member: int
    most: float
    stretch: float
    drawn: dict[str, float]

    @property
    def rows(self) -> pd.DataFrame:
        """The campaign's rows without readings."""
        return self.campaign.rows

    def only(self, values: Array) -> Array:
        """Values of the member (rows) as those of all six (rows × 6), zero elsewhere."""
        found = np.zeros((len(values), 6))
        found[:, self.member] = values
        return found


def series(rows: pd.DataFrame) -> Iterator[NDArray[np.intp]]:
    """Indices of the rows of each series, in order."""
    numbers = rows["series"].to_numpy()
    for number in dict.fromkeys(numbers.tolist()):
        yield np.flatnonzero(numbers == number)


def since_start(values: Array, rows: pd.DataFrame) -> Array:
    """Values (rows × any) less those of the first row of each series."""
    found = np.array(values, dtype=float)
    for own in series(rows):
        found[own] = found[own] - found[own[0]]
    return found
