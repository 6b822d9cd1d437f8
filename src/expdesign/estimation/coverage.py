"""How many readings that were not fitted lie within the 95 % intervals of their predictions.

The interval of a reading is that of the prediction, as `predict` states it, and of the reading's own noise, as `predict
--readings` adds it: σ² = (b·σ_r)² + sᵀPs, b being the Birge ratio of the fit and P the covariance of the model with it.

`Coverage` is that of an expanded uncertainty (JCGM 100:2008, 6.2 and annex G).
"""

from dataclasses import dataclass
from math import erf, sqrt
from statistics import NormalDist
from typing import Self

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.models.estimable import Estimable
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data

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


def held_out_rows(chain: Chain, test: Recordings, values: FloatArray, noise: FloatArray) -> HeldOutRows:
    """Rows that were not fitted as a chain predicts them at values (p,), in units of noise (k,) or (n, k).

    Where not every component was read, each reading stands for itself, so that k is 1.
    """
    if not len(test):
        return HeldOutRows(np.zeros((0, 0)), np.zeros((0, 0, 0)))
    predicted, slopes = chain.predict_with_sensitivities(row_data(test, chain.robot), values)
    scale, seen = np.broadcast_to(noise, test.deflections.shape), np.isfinite(test.deflections)
    residuals, slopes = (test.deflections - predicted[:, test.axes]) / scale, slopes[:, test.axes] / scale[..., None]
    if seen.all():
        return HeldOutRows(residuals, slopes)
    return HeldOutRows(residuals[seen][:, None], slopes[seen][:, None])


def reading_deviations(deviations: FloatArray, birge_ratio: float) -> FloatArray:
    """Standard deviation of a reading of each component, shape (k,): the RMS of the stated (N, k), widened."""
    found: FloatArray = birge_ratio * np.sqrt((deviations**2).mean(axis=0))
    return found


@dataclass(frozen=True)
class Coverage:
    """How often an interval of ± the expanded uncertainty U = k·u_c is to hold.

    Attributes:
        level: probability of a normal distribution within ±k standard deviations.
    """

    level: float

    @classmethod
    def of_factor(cls, k: float) -> Self:
        """The coverage of a normal distribution within ±k standard deviations (95.45 % for k = 2)."""
        return cls(erf(k / sqrt(2.0)))

    @property
    def factor(self) -> float:
        """K where the standard uncertainty itself is known."""
        return -NormalDist().inv_cdf((1.0 - self.level) / 2.0)

    def factors(self, degrees: FloatArray) -> FloatArray:
        """k_p = t_p(ν_eff) where the standard uncertainty was estimated with ν_eff degrees of freedom (G.3)."""
        factors, estimated = np.full(np.shape(degrees), self.factor), np.isfinite(degrees)
        if estimated.any():
            from scipy.special import stdtrit  # noqa: PLC0415 (slow to import, and few need it)

            factors[estimated] = -stdtrit(np.maximum(degrees[estimated], 1.0), (1.0 - self.level) / 2.0)
        return factors


STANDARD = Coverage.of_factor(2.0)
"""k = 2, about 95 %."""
