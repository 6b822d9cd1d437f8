"""Scaling of residuals to independent unit variance (theory.md 3)."""

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray


class Whitening:
    """Divides by standard deviations and, with a shared reference, decorrelates the rows of every series.

    Args:
        deviations: of every reading, shape (N, k).
        series: series of every row, shape (N,).
        shared_reference: whether half of each row's variance comes from the unloaded measurement that all rows of its
            series have in common.
    """

    def __init__(self, deviations: FloatArray, series: IntArray, *, shared_reference: bool = False) -> None:
        self.deviations = deviations
        self.shared_reference = shared_reference
        _, self._index = np.unique(series, return_inverse=True)
        self._sizes = np.bincount(self._index)

    def apply(self, values: FloatArray) -> FloatArray:
        """Whitened values; rows N, readings k, and any further dimensions: (N, k, ...) to the same shape.

        Within a series of r rows the scaled readings have covariance S = ½(I + 11ᵀ), whose symmetric inverse root is
        √2·(I − (1 − 1/√(1+r))·11ᵀ/r).
        """
        extra = (1,) * (values.ndim - 2)
        scaled = values / self.deviations.reshape(*self.deviations.shape, *extra)
        if not self.shared_reference:
            return scaled
        sums = np.zeros((len(self._sizes), *scaled.shape[1:]))
        np.add.at(sums, self._index, scaled)
        sizes = self._sizes.reshape(-1, *(1,) * (values.ndim - 1))
        means = sums / sizes * (1.0 - 1.0 / np.sqrt(1.0 + sizes))
        whitened: FloatArray = np.sqrt(2.0) * (scaled - means[self._index])
        return whitened

    def rows(self, chosen: BoolArray | IntArray, series: IntArray) -> "Whitening":
        """The whitening of some rows, whose series are given."""
        return Whitening(self.deviations[chosen], series, shared_reference=self.shared_reference)
