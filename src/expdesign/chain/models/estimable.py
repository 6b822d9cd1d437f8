"""What a fit knows of its parameters: a covariance on the estimable subspace, and the directions outside it.

Where two parameters do alike what the readings show, neither is determined but their sum is. With the singular value
decomposition Ã·D = U·Σ·Vᵀ of the sensitivities in units D = diag(1/‖ã_j‖) of the conditional standard deviations,

    P = D·V₁·Σ₁⁻²·V₁ᵀ·D,   N = D·V₂,

V₂ spanning the kernel. A linear combination sᵀθ is estimable if and only if sᵀN = 0, and has the variance sᵀ·P·s then,
whichever generalised inverse P is (Rao, Linear Statistical Inference, 2nd ed. 1973, section 4a); otherwise its variance
is infinite.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from expdesign.arrays import BoolArray, FloatArray

_SHARE = 1e-6
"""Share of a combination outside the estimable subspace, in conditional standard deviations, that is rounding."""


@dataclass(frozen=True)
class Estimable:
    """Covariance of every estimable combination of p parameters.

    Attributes:
        generalised: P, a covariance that is right for estimable combinations, shape (p, p), finite.
        directions: N, along which the readings say nothing, shape (p, d).
        resolution: D, standard deviation of each parameter if all others were known; for those that no reading shows,
            their typical size. Shape (p,).
    """

    generalised: FloatArray
    directions: FloatArray
    resolution: FloatArray

    @classmethod
    def from_covariance(cls, covariance: FloatArray) -> "Estimable":
        """Of a covariance (p, p) whose infinite rows mark parameters that are not determined, each for itself."""
        known = np.isfinite(np.diag(covariance))
        generalised = np.where(known[:, None] & known, covariance, 0.0)
        deviations = np.sqrt(np.maximum(np.diag(generalised), 0.0))
        return cls(generalised, np.eye(len(known))[:, ~known], np.where(known & (deviations > 0.0), deviations, 1.0))

    @property
    def determined(self) -> BoolArray:
        """Parameters that are estimable by themselves, shape (p,)."""
        outside = np.linalg.norm(self.directions, axis=1)
        determined: BoolArray = outside <= _SHARE * self.resolution
        return determined

    @cached_property
    def covariance(self) -> FloatArray:
        """P with infinite rows and columns of parameters that are not determined by themselves, shape (p, p)."""
        known = self.determined
        covariance: FloatArray = np.where(known[:, None] & known, self.generalised, np.inf)
        return covariance

    def deviations(self, sensitivities: FloatArray) -> FloatArray:
        """√(sᵀPs) of combinations s (..., p), infinite where they are not estimable; shape (...)."""
        variance = ((sensitivities @ self.generalised) * sensitivities).sum(axis=-1)
        deviation = np.sqrt(np.maximum(variance, 0.0))
        if self.directions.shape[1] == 0:
            return deviation
        outside = np.linalg.norm(sensitivities @ self.directions, axis=-1)
        whole = np.linalg.norm(sensitivities * self.resolution, axis=-1)
        found: FloatArray = np.where(outside > _SHARE * whole, np.inf, deviation)
        return found

    def scaled(self, factor: float) -> "Estimable":
        """The same with all variances multiplied."""
        return replace(self, generalised=factor * self.generalised)

    def in_units(self, units: FloatArray) -> "Estimable":
        """Of parameters multiplied by `units` (p,)."""
        return Estimable(
            self.generalised * np.outer(units, units), self.directions * units[:, None], self.resolution * units
        )
