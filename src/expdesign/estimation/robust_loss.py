"""Weights of rows for losses that grow slower than squares (iteratively re-weighted least squares)."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.integrate import quad
from scipy.special import gammaln, xlogy

from expdesign.arrays import FloatArray
from expdesign.estimation.arm_options import Loss

_CORNER = 1.345
"""Standard deviations where Huber's loss becomes linear: 95 % efficient at normal noise."""


@dataclass(frozen=True)
class Weighting:
    """Weights of rows by the mean square of their whitened residuals.

    Attributes:
        loss: see `ArmOptions.loss`.
        freedom: of Student's t.
    """

    loss: Loss
    freedom: float

    @property
    def robust(self) -> bool:
        """Whether weights differ from 1."""
        return self.loss != "squares"

    def weights(self, residuals: FloatArray) -> FloatArray:
        """Weights (N,) of rows with whitened residuals (N, k), 0 where nothing was read."""
        count = np.maximum((residuals != 0.0).sum(axis=1), 1)
        return self._weight((residuals**2).sum(axis=1), count)

    def share(self, components: int) -> float:
        """Mean of w·r² per component at normal noise, by which levels are made consistent."""
        return _share(self, components) if self.robust else 1.0

    def _weight(self, squares: FloatArray, count: FloatArray | float) -> FloatArray:
        if self.loss == "huber":
            size = np.sqrt(squares / count)
            return np.minimum(1.0, _CORNER / np.maximum(size, 1e-12))
        if self.loss == "student":
            return (self.freedom + count) / (self.freedom + squares)
        return np.ones_like(squares)


@lru_cache(maxsize=32)
def _share(weighting: Weighting, components: int) -> float:
    half = components / 2.0

    def integrand(squares: float) -> float:
        weight = float(weighting._weight(np.array([squares]), float(components))[0])
        density = xlogy(half - 1.0, squares / 2.0) - squares / 2.0 - gammaln(half) - np.log(2.0)  # of chi squared
        return weight * squares * float(np.exp(density))

    return float(quad(integrand, 0.0, 60.0 + 10.0 * components, limit=200)[0]) / components
