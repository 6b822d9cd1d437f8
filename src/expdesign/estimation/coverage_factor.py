"""The coverage that an expanded uncertainty has (JCGM 100:2008, 6.2 and annex G)."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.special import ndtr, ndtri, stdtrit

from expdesign.arrays import FloatArray


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
        return cls(float(1.0 - 2.0 * ndtr(-k)))

    @property
    def factor(self) -> float:
        """K where the standard uncertainty itself is known."""
        return float(-ndtri((1.0 - self.level) / 2.0))

    def factors(self, degrees: FloatArray) -> FloatArray:
        """k_p = t_p(ν_eff) where the standard uncertainty was estimated with ν_eff degrees of freedom (G.3)."""
        tail = (1.0 - self.level) / 2.0
        factors: FloatArray = -np.where(np.isfinite(degrees), stdtrit(np.maximum(degrees, 1.0), tail), ndtri(tail))
        return factors


STANDARD = Coverage.of_factor(2.0)
"""k = 2, about 95 %."""
