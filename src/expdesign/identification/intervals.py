"""Confidence intervals of compliances and stiffnesses (theory.md 3).

Where the noise is known the estimate is normal. Where its level is estimated the estimate follows Student's t; with two
levels (translations, rotations) the degrees of freedom are Satterthwaite's, ν = (Σ v_g)² / Σ (v_g²/ν_g), v_g being the
part of the variance that group g contributes. A stiffness' interval is the inverse of its compliance's: the compliance
is what enters linearly.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import norm, t

from expdesign.arrays import FloatArray
from expdesign.identification.fit import Fit
from expdesign.identification.noise_level import NoiseLevel

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Intervals:
    """Estimates with the ends of their confidence intervals, shape (p,) each."""

    estimate: FloatArray
    low: FloatArray
    high: FloatArray

    def inverse(self) -> "Intervals":
        """Intervals of 1/x for x > 0: the high end is infinite where x may be 0, and all is NaN where x < 0."""
        with np.errstate(divide="ignore"):
            low = np.where(self.high > 0.0, 1.0 / self.high, np.nan)
            high = np.where(self.low > 0.0, 1.0 / self.low, np.inf)
        return Intervals(1.0 / self.estimate, low, np.where(self.high > 0.0, high, np.nan))


def degrees_of_freedom(fit: Fit, noise: NoiseLevel) -> FloatArray:
    """Degrees of freedom of every parameter's variance, infinite where the noise is known, shape (p,)."""
    if noise.known:
        return np.full(len(fit.values), np.inf)
    parts = []
    for group in noise.groups:
        rows = fit.sensitivities[:, group.columns].reshape(-1, len(fit.values)) @ fit.covariance
        parts.append(((rows**2).sum(axis=0), group.dof))
    variance = np.diag(fit.covariance)
    spread = sum(part**2 / dof for part, dof in parts)
    return variance**2 / np.maximum(spread, 1e-300 * variance**2)


def parameter_intervals(fit: Fit, noise: NoiseLevel, confidence: float = CONFIDENCE) -> Intervals:
    """Intervals of the parameters of a fit, in their own units."""
    dof = degrees_of_freedom(fit, noise)
    tail = 0.5 + 0.5 * confidence
    finite = np.isfinite(dof)
    quantile = np.where(finite, t.ppf(tail, np.where(finite, dof, 1.0)), norm.ppf(tail))
    half = quantile * np.sqrt(np.diag(fit.covariance))
    return Intervals(fit.values, fit.values - half, fit.values + half)
