"""Design variables: what may be chosen about one measurement, one file entry per variable."""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray


@dataclass(frozen=True)
class Interval:
    """A quantity that may take any value between two bounds (equal bounds fix it)."""

    low: float
    high: float


@dataclass(frozen=True)
class Choices:
    """A quantity that may take one of a list of values."""

    values: tuple[float, ...]


Quantity = Interval | Choices


def fixed(value: float) -> Interval:
    """A quantity that cannot be chosen."""
    return Interval(value, value)


@dataclass(frozen=True)
class Rows:
    """Several quantities that are chosen together as one row of a table, shape (rows, columns)."""

    table: FloatArray

    def __post_init__(self) -> None:
        self.table.setflags(write=False)


@dataclass(frozen=True)
class Variable:
    """One decision of a measurement.

    Attributes:
        columns: indices of the quantities that it sets.
        domain: an interval (the decision is the quantity) or rows to choose from (the decision is the row's index).
    """

    columns: tuple[int, ...]
    domain: Interval | Rows

    @property
    def discrete(self) -> bool:
        """Whether the decision is an index."""
        return isinstance(self.domain, Rows)

    @property
    def bounds(self) -> tuple[float, float]:
        """Smallest and largest decision."""
        if isinstance(self.domain, Rows):
            return 0.0, float(len(self.domain.table) - 1)
        return self.domain.low, self.domain.high


def variables_for(quantities: dict[int, Quantity]) -> list[Variable]:
    """Variables of the quantities that can be chosen at all, one each."""
    variables = []
    for column, quantity in quantities.items():
        if isinstance(quantity, Choices):
            if len(quantity.values) > 1:
                variables.append(Variable((column,), Rows(np.array(quantity.values)[:, None])))
        elif quantity.low < quantity.high:
            variables.append(Variable((column,), quantity))
    return variables
