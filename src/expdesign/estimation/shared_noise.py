"""Noise that readings share: what nobody asks for, left out of the parameters by its marginal covariance.

What readings share is Z·v with v ~ N(0, I), so that their noise has the covariance

    V = I + Z·Zᵀ,   V^(−1/2) = I + U·diag((1 + s²)^(−1/2) − 1)·Uᵀ,   Z = U·diag(s)·Wᵀ,

and the estimates of all other parameters are those with v among the parameters.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from expdesign.arrays import BoolArray, FloatArray


@dataclass(frozen=True)
class SharedNoise:
    """Noise that readings share.

    Attributes:
        turned: U, shape (M, r).
        squares: s², shape (r,).
    """

    turned: FloatArray
    squares: FloatArray

    @classmethod
    def of(cls, columns: FloatArray) -> Self:
        """Of Z, shape (M, q)."""
        left, singular, _ = np.linalg.svd(columns, full_matrices=False)
        return cls(left, singular**2)

    @property
    def log_determinant(self) -> float:
        """ln|V|."""
        return float(np.log1p(self.squares).sum())

    def whitened(self, readings: FloatArray) -> FloatArray:
        """V^(−1/2) times readings (M,) or derivatives of them (M, p)."""
        return self._times((1.0 + self.squares) ** -0.5, readings)

    def restored(self, whitened: FloatArray) -> FloatArray:
        """V^(1/2) times whitened readings (M,) or derivatives of them (M, p)."""
        return self._times((1.0 + self.squares) ** 0.5, whitened)

    def _times(self, factors: FloatArray, values: FloatArray) -> FloatArray:
        found: FloatArray = values + (self.turned * (factors - 1.0)) @ (self.turned.T @ values)
        return found

    def among(self, whitened: FloatArray, kept: BoolArray) -> FloatArray:
        """V^(−1/2) times those of whitened readings (N, k, ...) that count, row after row (N·k,)."""
        flat = whitened.reshape(whitened.shape[0] * whitened.shape[1], *whitened.shape[2:]).copy()
        flat[kept] = self.whitened(flat[kept])
        return flat.reshape(whitened.shape)
