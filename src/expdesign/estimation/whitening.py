"""Scaling of residuals to independent unit variance (theory.md 3)."""

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray, TextArray
from expdesign.chain.recordings.references import groups


class Whitening:
    """Divides by standard deviations and decorrelates the rows that share an unloaded reading.

    Args:
        deviations: of every reading, shape (N, k).
        references: name of every row's unloaded reading, which carries half of the row's variance, shape (N,)
            (`chain/recordings/references.py`); None where no two rows share one.
    """

    def __init__(self, deviations: FloatArray, *, references: TextArray | None = None) -> None:
        self.deviations = deviations
        self._references = references
        self._index = np.arange(len(deviations)) if references is None else groups(references)
        self._sizes = np.bincount(self._index)

    def apply(self, values: FloatArray) -> FloatArray:
        """Whitened values; rows N, readings k, and any further dimensions: (N, k, ...) to the same shape.

        The scaled readings of r rows with one reference have covariance S = ½(I + 11ᵀ), whose symmetric inverse root is
        √2·(I − (1 − 1/√(1+r))·11ᵀ/r); for r = 1 it is 1.
        """
        extra = (1,) * (values.ndim - 2)
        return self.decorrelated(values / self.deviations.reshape(*self.deviations.shape, *extra))

    def decorrelated(self, scaled: FloatArray) -> FloatArray:
        """The symmetric inverse root alone, of values (N, k, ...) in standard deviations."""
        if len(self._sizes) == len(scaled):  # no two rows share one
            return scaled
        sums = np.zeros((len(self._sizes), *scaled.shape[1:]))
        np.add.at(sums, self._index, scaled)
        sizes = self._sizes.reshape(-1, *(1,) * (scaled.ndim - 1))
        means = sums / sizes * (1.0 - 1.0 / np.sqrt(1.0 + sizes))
        whitened: FloatArray = np.sqrt(2.0) * (scaled - means[self._index])
        return whitened

    @property
    def precision(self) -> FloatArray:
        """Diagonal of S⁻¹, shape (N,): 2·r/(1 + r) for a row whose reference r rows have, itself among them."""
        sizes = self._sizes[self._index].astype(float)
        precision: FloatArray = 2.0 * sizes / (1.0 + sizes)
        return precision

    def rows(self, chosen: BoolArray | IntArray) -> "Whitening":
        """The whitening of some rows."""
        references = None if self._references is None else self._references[chosen]
        return Whitening(self.deviations[chosen], references=references)
