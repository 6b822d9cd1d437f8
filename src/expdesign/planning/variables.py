"""Design variables: what may be chosen about one measurement, one file entry per variable.

Continuous quantities are set in whole steps, so that a plan means what it says. A search moves poses by 1e-11 m where
that pays on paper (two poses that are equal to any controller then count as two, each with an unloaded measurement of
its own). Designs are therefore rounded to whole steps before they are judged: measurements whose poses differ by less
than a step are at the same pose, and every criterion is that of the plan as it is written. Choices, candidates and
fixed values are taken as they are given.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from itertools import product

import numpy as np

from expdesign.arrays import BoolArray, FloatArray


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


FINEST = {"_m": 1e-6, "_rad": 1e-6, "_kg": 1e-4, "_N": 1e-3, "_Nm": 1e-4}
"""Steps by the unit at the end of a quantity's name, where the configuration states none."""
_PARTS = 1000
"""A step that the configuration does not state is at most this part of its interval."""
_DIMENSIONS = 8
_FURTHER, _REACH = 256, 4


def steps_of(names: tuple[str, ...], widths: FloatArray, given: Mapping[str, float]) -> FloatArray:
    """The step of each quantity, shape (n_q,): as given, or by its unit, finer where its interval is short.

    Args:
        names: of the quantities, which end in their unit.
        widths: of the intervals in which they may be chosen, shape (n_q,); 0 where they are fixed.
        given: steps that the configuration states.
    """
    steps = np.empty(len(names))
    for index, (name, width) in enumerate(zip(names, widths, strict=True)):
        usual = FINEST.get("_" + name.rsplit("_", 1)[-1], 1.0)  # a tip's number has no unit
        short = 10.0 ** np.floor(np.log10(width / _PARTS)) if width > 0.0 else usual
        steps[index] = given.get(name, min(usual, float(f"{short:.0e}")))
    return steps


class Grid:
    """The values that continuous decisions can be set to: whole multiples of a step between two bounds.

    Args:
        steps: of each decision, shape (g,); 0 for a decision that is an index.
        lower: bounds, shape (g,).
        upper: bounds, shape (g,).

    Attributes:
        lower: smallest multiple within the bounds, shape (g,).
        upper: largest multiple within the bounds, shape (g,); where there is none, `lower` exceeds it.
    """

    def __init__(self, steps: FloatArray, lower: FloatArray, upper: FloatArray) -> None:
        self.steps, self._stepped = steps, steps > 0.0
        self._safe = np.where(self._stepped, steps, 1.0)
        exponents = [Decimal(repr(float(step))).normalize().as_tuple().exponent for step in self._safe]
        self._decimals = 10.0 ** np.array([max(0, -int(exponent)) for exponent in exponents])
        # A bound that is a multiple but for rounding is one.
        low, high = np.ceil(lower / self._safe - 1e-9), np.floor(upper / self._safe + 1e-9)
        self.lower = np.where(self._stepped, self._multiple(low), lower)
        self.upper = np.where(self._stepped, self._multiple(high), upper)

    @property
    def empty(self) -> BoolArray:
        """Whether no value can be set, shape (g,)."""
        return self._stepped & (self.lower > self.upper)

    def nearest(self, decisions: FloatArray) -> FloatArray:
        """The nearest values that can be set, of decisions (..., g)."""
        rounded = np.clip(self._multiple(np.rint(decisions / self._safe)), self.lower, self.upper)
        return np.where(self._stepped, rounded, decisions)

    def _multiple(self, counts: FloatArray) -> FloatArray:
        """The doubles nearest to whole multiples of the steps, so that 0.02 is not written as 0.019999999999999997."""
        multiples: FloatArray = np.rint(counts * self._safe * self._decimals) / self._decimals + 0.0
        return multiples

    def inward(
        self, decisions: FloatArray, wanted: FloatArray, moved: BoolArray, excess: Callable[[FloatArray], FloatArray]
    ) -> FloatArray:
        """Decisions (r, g) that can be set and are within limits, each the nearest to what was `wanted` (r, g).

        The corners of the cell of the grid around what was wanted are tried, then multiples within a few steps. Where
        none is within the limits, the nearest multiple stays.

        Args:
            decisions: rounded, beyond the limits.
            wanted: within the limits, not rounded.
            moved: the decisions that limits depend on, shape (g,).
            excess: over the limits, of decisions (..., g); at most 0 within.
        """
        free = np.flatnonzero(moved & self._stepped)
        if not free.size:
            return decisions
        generator = np.random.default_rng(0)
        further = generator.integers(-_REACH, _REACH + 1, size=(_FURTHER, len(free))).astype(float)
        corners = np.array(list(product((0.0, 1.0), repeat=len(free)))) if len(free) <= _DIMENSIONS else further
        result = decisions.copy()
        for row, (start, aim) in enumerate(zip(decisions, wanted, strict=True)):
            cell = np.floor(aim[free] / self.steps[free])
            for offsets in (corners, further):
                tried = np.repeat(start[None], len(offsets), axis=0)
                tried[:, free] = (cell + offsets) * self.steps[free]
                tried = self.nearest(tried)
                distance = (((tried - aim)[:, free] / self.steps[free]) ** 2).sum(axis=1)
                distance[excess(tried) > 0.0] = np.inf
                best = int(np.argmin(distance))
                if np.isfinite(distance[best]):
                    result[row] = tried[best]
                    break
        return result
