"""Designs whose criteria can be differentiated: one recorded evaluation of a batch, and a backward pass per gradient.

Nothing of the model stands here. The measurements, the assessment and the criteria are evaluated as for their values,
on a recorded array of the quantities of the measurements (`differentiation.py`). Designs are independent, so that one
backward pass gives the gradients of a whole batch.
"""

from dataclasses import dataclass
from functools import reduce
from operator import add

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.mechanics.differentiation import gradient, independent, plain
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import Criterion, criterion_values
from expdesign.planning.problem import DesignProblem


@dataclass(frozen=True)
class Piece:
    """A smooth function of b designs: a criterion, or one of the functions of which it is the maximum.

    Attributes:
        value: shape (b,).
    """

    value: FloatArray
    _result: FloatArray
    designs: "Differentiated"
    _sign: float = 1.0

    @property
    def signed(self) -> FloatArray:
        """The value, recorded."""
        return self._sign * self._result

    def gradient(self) -> FloatArray:
        """With respect to the design variables (0 for discrete ones), shape (b, m, g)."""
        return to_variables(self.designs.problem, self.quantity_gradient())

    def quantity_gradient(self) -> FloatArray:
        """With respect to every quantity of the measurements, free or fixed, shape (b, m, z); 0 where it has none."""
        found = gradient(self._result, np.full(self.value.shape, self._sign), self.designs.quantities)
        regular = self.designs.regular
        return found if regular.all() else np.where(regular[:, None, None], found, 0.0)

    def negated(self) -> "Piece":
        """The same with the other sign."""
        return Piece(-self.value, self._result, self.designs, -self._sign)


def weighted_gradient(pieces: list[Piece], weights: FloatArray) -> FloatArray:
    """Gradient (b, m, g) of the sum of pieces of the same designs with weights (j, b), by one backward pass."""
    designs = pieces[0].designs
    with np.errstate(all="ignore"):
        terms = [piece.signed * weight for piece, weight in zip(pieces, weights, strict=True) if weight.any()]
        total = reduce(add, terms, np.zeros(len(designs.regular)))
    return Piece(plain(total), total, designs).gradient()


class Differentiated:
    """One evaluation of b designs of m measurements, the series held.

    Args:
        problem: the design problem.
        quantities: of every measurement, free or fixed, shape (b, m, z).
        series: series numbers (b, m) where measurements share their reference; they follow from the poses if left out.

    Attributes:
        regular: whether the measurements identify every parameter, shape (b,); elsewhere values are NaN and
            derivatives zero.
    """

    def __init__(self, problem: DesignProblem, quantities: FloatArray, series: IntArray | None = None) -> None:
        self.problem, self.quantities = problem, quantities
        if series is None:
            series = shared_series(problem, quantities)
        with np.errstate(all="ignore"):
            self.assessment: Assessment = problem.assess(*problem.space.split(independent(quantities)), series)
            self.regular: BoolArray = self.assessment.differentiable

    @classmethod
    def of_designs(
        cls, problem: DesignProblem, designs: FloatArray, series: IntArray | None = None
    ) -> "Differentiated":
        """The designs with variables (b, m, g)."""
        return cls(problem, problem.space.quantities(designs), series)

    def pieces(self, criterion: Criterion) -> list[Piece]:
        """The smooth pieces of a criterion, its own value first; a smooth criterion is its own single piece.

        Raises:
            InputError: the criterion cannot be differentiated.
        """
        self.assessment.place, self.assessment.pieces = 0, 1
        found = [self._piece(criterion)]
        for place in range(1, self.assessment.pieces):
            self.assessment.place = place
            found.append(self._piece(criterion))
        self.assessment.place = 0
        return found

    def _piece(self, criterion: Criterion) -> Piece:
        with np.errstate(all="ignore"):
            result = criterion_values(criterion, self.assessment)
        value = np.asarray(plain(result), dtype=float)
        return Piece(np.where(self.regular, value, np.nan), result, self)


def shared_series(problem: DesignProblem, quantities: FloatArray) -> IntArray | None:
    """Series numbers (b, m) of designs whose measurements share their reference, or may be left out; else None."""
    series = problem.space.series(quantities)
    return problem.noise.series(quantities[..., : problem.space.n_pose]) if series is None else series


def to_variables(problem: DesignProblem, by_quantities: FloatArray) -> FloatArray:
    """Gradients with respect to quantities (..., z) as those with respect to design variables (..., g)."""
    space = problem.space
    return np.where(space.discrete, 0.0, by_quantities[..., space.columns])
