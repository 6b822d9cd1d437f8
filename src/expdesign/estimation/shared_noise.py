"""Noise that readings share: what nobody asks for, left out of the parameters by its marginal covariance.

What readings share is Z·v with v ~ N(0, I), so that their noise has the covariance

    V = I + Z·Zᵀ,   V^(−1/2) = I + U·diag((1 + s²)^(−1/2) − 1)·Uᵀ,   Z = U·diag(s)·Wᵀ,

and the estimates of all other parameters are those with v among the parameters.
"""

from collections.abc import Sequence
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
    def of_laws(cls, laws: Sequence[FloatArray], variances: Sequence[float]) -> Self:
        """What laws do of which only the sizes are known.

        Args:
            laws: directions of each, shape (M, f_k).
            variances: σ_k², in variances of the noise.
        """
        shared = np.hstack([law * np.sqrt(variance) for law, variance in zip(laws, variances, strict=True)])
        left, singular, _ = np.linalg.svd(shared, full_matrices=False)
        return cls(left, singular**2)

    def whitened(self, readings: FloatArray) -> FloatArray:
        """V^(−1/2) times readings (M,) or derivatives of them (M, p)."""
        change = (1.0 + self.squares) ** -0.5 - 1.0
        found: FloatArray = readings + (self.turned * change) @ (self.turned.T @ readings)
        return found

    def among(self, whitened: FloatArray, kept: BoolArray) -> FloatArray:
        """V^(−1/2) times those of whitened readings (N, k, ...) that count, row after row (N·k,)."""
        flat = whitened.reshape(whitened.shape[0] * whitened.shape[1], *whitened.shape[2:]).copy()
        flat[kept] = self.whitened(flat[kept])
        return flat.reshape(whitened.shape)
