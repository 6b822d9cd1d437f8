"""Levenberg-Marquardt: the descent of every estimator, of least squares with normal priors and bounds.

The damping is in parts of the diagonal (Marquardt, J. SIAM 11, 1963, 431). A step is cut off at the bounds, and
parameters that they hold are left out. The normal equations that give a step square the condition number, which costs
steps but no accuracy: the minimum is where the exact gradient vanishes.
"""

from collections.abc import Callable

import numpy as np

from expdesign.arrays import FloatArray

_STEPS = 60
_LARGEST_DAMPING = 1e10

Linearised = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""Whitened residuals (M,) and derivatives of the prediction (M, p) at parameters (p,)."""


class Descent:
    """Where a descent is: at `values` (p,), with `residuals` (M,) and `slopes` (M, p) there.

    Args:
        linearised: residuals and derivatives.
        start: parameters, shape (p,), which the bounds cut off.
        mean: of the prior, shape (p,).
        low, high: bounds, shape (p,).
    """

    def __init__(
        self, linearised: Linearised, start: FloatArray, mean: FloatArray, low: FloatArray, high: FloatArray
    ) -> None:
        self._linearised, self._mean, self._low, self._high = linearised, mean, low, high
        self.values: FloatArray = np.clip(start, low, high)
        self.residuals, self.slopes = linearised(self.values)
        self._damping = 1e-3

    def run(self, precision: FloatArray, enough: Callable[[float], float], promised: float = 1.0) -> None:
        """Steps with prior precisions (p,), in units of the residuals, until one gains no more than is `enough`.

        Args:
            precision: 0 where nothing is known beforehand.
            enough: fall of the cost below which it has settled, by the cost.
            promised: part of that below which a step is not made, by what it promises.
        """
        away = self.values - self._mean
        cost = float(self.residuals @ self.residuals + away**2 @ precision)
        for _ in range(_STEPS):
            tolerance = enough(cost)
            gradient = self.slopes.T @ self.residuals - precision * (self.values - self._mean)
            held = (self.values <= self._low) & (gradient < 0.0) | (self.values >= self._high) & (gradient > 0.0)
            free = np.flatnonzero(~held)
            gram = self.slopes[:, free].T @ self.slopes[:, free] + np.diag(precision[free])
            scale = 1.0 / np.sqrt(np.maximum(gram.diagonal(), 1e-300))
            gram *= np.outer(scale, scale)
            gained = None
            while self._damping < _LARGEST_DAMPING:
                step = np.linalg.solve(gram + self._damping * np.eye(len(free)), gradient[free] * scale) * scale
                if float(gradient[free] @ step) <= promised * tolerance:
                    break
                trial = self.values.copy()
                trial[free] = np.clip(trial[free] + step, self._low[free], self._high[free])
                # Most steps are accepted: with the derivatives at once, the next one needs no further evaluation.
                residuals, slopes = self._linearised(trial)
                lower = float(residuals @ residuals + (trial - self._mean) ** 2 @ precision)
                if np.isfinite(lower) and lower <= cost:
                    gained = cost - lower
                    self.values, self.residuals, self.slopes, cost = trial, residuals, slopes, lower
                    break
                self._damping *= 5.0
            self._damping = max(self._damping / 10.0, 1e-9)
            if gained is None or gained <= tolerance:
                break
