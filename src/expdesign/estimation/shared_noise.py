"""Noise that readings share: what nobody asks for, left out of the parameters by its marginal covariance.

What a group of readings shares is Z·v with v ~ N(0, φ·I), so that their noise has the covariance

    V = I + φ·Z·Zᵀ,   V^(−1/2) = I + U·diag((1 + φ·s²)^(−1/2) − 1)·Uᵀ,   Z = U·diag(s)·Wᵀ,

and the estimates of all other parameters are those with v among the parameters.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class SharedNoise:
    """Noise that groups of readings share.

    Attributes:
        groups: readings of every group, shape (n_k,).
        turned: U of each, shape (n_k, r_k).
        squares: s² of each, shape (r_k,).
        ratio: φ; 0 where nothing is shared.
    """

    groups: tuple[IntArray, ...] = ()
    turned: tuple[FloatArray, ...] = ()
    squares: tuple[FloatArray, ...] = ()
    ratio: float = 0.0

    @classmethod
    def of_laws(cls, laws: Sequence[FloatArray], variances: Sequence[float]) -> Self:
        """What laws do of which only the sizes are known.

        Args:
            laws: directions of each, shape (M, f_k).
            variances: σ_k², in variances of the noise.
        """
        if not laws:
            return cls()
        shared = np.hstack([law * np.sqrt(variance) for law, variance in zip(laws, variances, strict=True)])
        left, singular, _ = np.linalg.svd(shared, full_matrices=False)
        return cls((np.arange(len(shared)),), (left,), (singular**2,), 1.0)

    def whitened(self, readings: FloatArray) -> FloatArray:
        """V^(−1/2) times readings (M,) or derivatives of them (M, p)."""
        return self._scaled(readings, -0.5)

    def unwhitened(self, readings: FloatArray) -> FloatArray:
        """V^(1/2) times readings (M,)."""
        return self._scaled(readings, 0.5)

    def among(self, whitened: FloatArray, kept: BoolArray) -> FloatArray:
        """V^(−1/2) times those of whitened readings (N, k, ...) that count, row after row (N·k,)."""
        flat = whitened.reshape(whitened.shape[0] * whitened.shape[1], *whitened.shape[2:]).copy()
        flat[kept] = self.whitened(flat[kept])
        return flat.reshape(whitened.shape)

    def _scaled(self, readings: FloatArray, power: float) -> FloatArray:
        if self.ratio == 0.0:
            return readings
        scaled = readings.copy()
        for rows, turned, squares in zip(self.groups, self.turned, self.squares, strict=True):
            change = (1.0 + self.ratio * squares) ** power - 1.0
            scaled[rows] += (turned * change) @ (turned.T @ readings[rows])
        return scaled
