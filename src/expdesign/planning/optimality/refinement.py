"""What the refinement of candidates for a bound gives: its rounds, and the bound."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.optimality.weights import Dual


class LowerBound(NamedTuple):
    """A number that no plan can beat (None where there is none), and what it was certified on, in words."""

    value: float | None
    certified_on: str


@dataclass(frozen=True)
class Refinement:
    """One round.

    Attributes:
        shortlist: candidates with weight, and the most sensitive of the others, shape (j, g).
        weights: of the shortlist, shape (j,).
        value: optimum of the relaxation over the candidates so far, the criterion squared.
        bound: lower bound over the whole design space, the criterion squared.
        words: how the largest sensitivity was found.
        count: m.
        dual: Q of the bound.
        largest: ‖R·Q‖² of any candidate per measurement is at most.
    """

    shortlist: FloatArray
    weights: FloatArray
    value: float
    bound: float
    words: str
    count: int
    dual: Dual
    largest: float

    @property
    def support(self) -> FloatArray:
        """The weights that count, falling."""
        found: FloatArray = np.sort(self.weights[self.weights > 0.01])[::-1]
        return found

    @property
    def needs_parts(self) -> bool:
        """Whether the optimum takes measurements a number of times that is not whole."""
        times = self.count * self.support
        return len(times) > self.count or bool(np.abs(times - np.rint(times)).max() > 0.1)
