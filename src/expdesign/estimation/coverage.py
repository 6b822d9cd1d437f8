"""How many readings that were not fitted lie within the 95 % intervals of their predictions.

The interval of a reading is that of the prediction, as `predict` states it, and of the reading's own noise, as `predict
--readings` adds it: σ² = (b·σ_r)² + sᵀPs, b being the Birge ratio of the fit and P the covariance of the model with it.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.models.estimable import Estimable

NORMAL_95 = 1.959963984540054
"""Half of a 95 % interval in standard deviations of a normal distribution."""


@dataclass(frozen=True)
class HeldOutRows:
    """Readings that were not fitted, in standard deviations of their noise.

    Attributes:
        residuals: measured minus predicted, shape (N, k).
        sensitivities: of the prediction, shape (N, k, p).
    """

    residuals: FloatArray
    sensitivities: FloatArray

    def within(self, known: Estimable, birge_ratio: float) -> tuple[int, int]:
        """How many lie within their 95 % intervals, and how many have one.

        Args:
            known: of the parameters, with all that widens them.
            birge_ratio: by which the noise of the readings is larger than stated.
        """
        if not self.residuals.size:
            return 0, 0
        deviations = np.hypot(birge_ratio, known.deviations(self.sensitivities))
        finite = np.isfinite(deviations)
        return int((np.abs(self.residuals) <= NORMAL_95 * deviations)[finite].sum()), int(finite.sum())

    def coverage(self, known: Estimable, birge_ratio: float) -> float:
        """The share of those that have an interval; NaN where none has."""
        within, all_of_them = self.within(known, birge_ratio)
        return within / all_of_them if all_of_them else float("nan")


NONE_HELD_OUT = HeldOutRows(np.zeros((0, 0)), np.zeros((0, 0, 0)))


def reading_deviations(deviations: FloatArray, birge_ratio: float) -> FloatArray:
    """Standard deviation of a reading of each component, shape (k,): the RMS of the stated (N, k), widened."""
    found: FloatArray = birge_ratio * np.sqrt((deviations**2).mean(axis=0))
    return found
