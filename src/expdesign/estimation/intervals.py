"""Confidence intervals of compliances and stiffnesses (theory.md 3).

Where the noise is known the estimate is normal. Where its level is estimated the estimate follows Student's t. With two
levels (translations, rotations) the weights of the readings are estimates too, which makes the compliances less certain
than (ÃᵀÃ)⁻¹ says; the covariance is then adjusted, and the degrees of freedom are found, after Kenward and Roger
(Biometrics 53, 1997). With Φ = (ÃᵀÃ)⁻¹, A_g = Ã_gᵀÃ_g of the readings of group g and the relative covariance W of the
estimated variances σ_g²,

    Λ = Σ_g W_gg A_g − Σ_gh W_gh A_g Φ A_h,   Φ_A = Φ + 2ΦΛΦ,   ν = 2 (Φ_jj)² / Σ_gh v_g W_gh v_h,   v_g = (Φ A_g Φ)_jj.

Variances estimated from residuals have W⁻¹ = ½(n_g δ_gh − 2 tr(A_gΦ) δ_gh + tr(A_gΦA_hΦ)), those from replicates
W = diag(2/ν_g). With six full measurements of a hexapod such 95 % intervals cover the truth in 94 to 95 of 100
experiments; with three or four, whose noise levels have few degrees of freedom, in 92 to 95.

Where the noise is known and χ² refutes the model, standard deviations grow by the Birge ratio √(χ²/ν)
(`goodness.Goodness.birge_ratio`), and the estimate follows Student's t with ν degrees of freedom.

A stiffness' interval is the inverse of its compliance's: the compliance is what enters linearly.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtri, stdtrit

from expdesign.arrays import FloatArray
from expdesign.chain.models.estimable import Estimable
from expdesign.estimation.fit import Fit
from expdesign.estimation.noise_level import NoiseLevel

_TAIL = 0.975
"""Probability below the upper end of a 95 % interval."""


@dataclass(frozen=True)
class Intervals:
    """Estimates with the ends of their confidence intervals, shape (p,) each."""

    estimate: FloatArray
    low: FloatArray
    high: FloatArray

    def part(self, chosen: slice) -> "Intervals":
        """The intervals of some of the parameters."""
        return Intervals(self.estimate[chosen], self.low[chosen], self.high[chosen])

    def inverse(self) -> "Intervals":
        """Intervals of 1/x for x > 0: the high end is infinite where x may be 0, and all is NaN where x < 0."""
        with np.errstate(divide="ignore"):
            low = np.where(self.high > 0.0, 1.0 / self.high, np.nan)
            high = np.where(self.low > 0.0, 1.0 / self.low, np.inf)
            estimate = 1.0 / self.estimate
        return Intervals(estimate, low, np.where(self.high > 0.0, high, np.nan))


@dataclass(frozen=True)
class Uncertainty:
    """How well the parameters of a fit are known.

    Attributes:
        estimable: the covariance of what is determined of the p parameters.
        dof: degrees of freedom of each variance, infinite where the noise is known, shape (p,).
    """

    estimable: Estimable
    dof: FloatArray

    def inflated(self, birge_ratio: float, dof: int) -> "Uncertainty":
        """Standard deviations multiplied by a Birge ratio that was estimated with `dof` degrees of freedom."""
        if birge_ratio == 1.0:
            return self
        return Uncertainty(self.estimable.scaled(birge_ratio**2), np.minimum(self.dof, float(dof)))

    def intervals(self, estimate: FloatArray) -> Intervals:
        """Intervals around estimates (p,) in the units of the covariance."""
        finite = np.isfinite(self.dof)
        quantile = np.where(finite, stdtrit(np.where(finite, self.dof, 1.0), _TAIL), ndtri(_TAIL))
        half = quantile * np.sqrt(np.diag(self.estimable.covariance))
        return Intervals(estimate, estimate - half, estimate + half)


def uncertainty(fit: Fit, noise: NoiseLevel) -> Uncertainty:
    """Covariance and degrees of freedom of a fit, allowing for what the noise level was estimated from."""
    count = fit.sensitivities.shape[-1]
    if noise.known:
        return Uncertainty(fit.estimable, np.full(count, np.inf))
    covariance = fit.estimable.generalised
    rows = [fit.sensitivities[:, group.columns].reshape(-1, count) for group in noise.groups]
    information = [part.T @ part for part in rows]
    seen = [part @ covariance for part in information]
    if noise.origin == "replicates":
        spread = np.diag([2.0 / group.dof for group in noise.groups])
    else:
        overlap = np.array([[np.trace(first @ second) for second in seen] for first in seen])
        free = np.array([len(part) - 2.0 * np.trace(each) for part, each in zip(rows, seen, strict=True)])
        spread = np.linalg.pinv(0.5 * (np.diag(free) + overlap), hermitian=True)
    excess = sum(spread[g, g] * part for g, part in enumerate(information))
    for g, first in enumerate(seen):
        for h, second in enumerate(information):
            excess = excess - spread[g, h] * (first @ second)
    adjusted = covariance + 2.0 * covariance @ excess @ covariance
    parts = np.array([np.diag(covariance @ part) for part in seen])
    scatter = np.einsum("gj,gh,hj->j", parts, spread, parts)
    variance = np.diag(covariance)
    dof = 2.0 * variance**2 / np.maximum(scatter, 1e-300 * variance**2)
    return Uncertainty(replace(fit.estimable, generalised=(adjusted + adjusted.T) / 2.0), dof)
