"""Variances of the attained poses at the targets, and how criteria sum them up (theory.md 4.3, 5.4, 6)."""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.mechanics.differentiation import plain, square_root
from expdesign.planning.criteria.targets import Targets

PIECES = 6
"""Largest number of pieces of a maximum that are looked at at a time."""


class TargetVariances:
    """Variances at t targets, for any batch of designs.

    Attributes:
        targets: where accuracy is wanted.
        noise_variance: U_ii due to measurement noise (m², rad²), shape (..., t, n).
        force_variance: (Z·Σ_F·Zᵀ)_ii due to load errors (m², rad²), shape (..., t, n).
        place: which of the values in `largest` is taken, from 0; others than 0 are the further pieces of a maximum.
        pieces: how many pieces the criteria evaluated so far have.
    """

    targets: Targets
    noise_variance: FloatArray
    force_variance: FloatArray
    place: int = 0
    pieces: int = 1

    def weighted(self, variance: FloatArray) -> FloatArray:
        """Σ_i variance_ii/tol_i² per target, shape (..., t), from (..., t, n); NaN where an axis that matters is."""
        importance = self.targets.importance
        terms = variance * importance
        if not (importance > 0.0).all():
            terms = np.where(importance > 0.0, terms, 0.0)
        weighted: FloatArray = terms.sum(axis=-1)
        return weighted

    def aggregated(self, squares: FloatArray) -> FloatArray:
        """Root of the mean or maximum over targets of squares (..., t), shape (...)."""
        if self.targets.aggregate == "max":
            return square_root(self.largest(squares))
        return square_root((squares * (self.targets.weights / self.targets.weights.sum())).sum(axis=-1))

    def largest(self, values: FloatArray, pieces: int = PIECES) -> FloatArray:
        """The largest of values (..., t), shape (...): the maximum of smooth pieces, where t are targets for example.

        A maximum is not differentiable where two values tie. Written with `largest`, its further pieces (the second
        largest value, …) can be evaluated one by one with `place`, as refinement by gradients and optimality
        conditions need them, up to `pieces`; its own gradient is then that of the piece that comes first.
        """
        count = values.shape[-1]
        self.pieces = max(self.pieces, min(pieces, count))
        order = np.argsort(-np.nan_to_num(plain(values)), axis=-1, kind="stable")
        chosen = np.arange(count) == order[..., min(self.place, count - 1), None]
        return (values * chosen).sum(axis=-1)


class GivenVariances(TargetVariances):
    """Variances that were computed elsewhere."""

    def __init__(self, targets: Targets, noise_variance: FloatArray, force_variance: FloatArray) -> None:
        self.targets, self.noise_variance, self.force_variance = targets, noise_variance, force_variance
