"""Least squares with normal priors whose factors the readings decide, by damped steps that also reach far minima.

Damped steps (`descent.py`) find the parameters at given factors, and MacKay's fixed point on the problem linearised
there finds the factors and, where it is not known, the noise (1992, section 4). Both take turns until the factors stay.
Where a tool hardly turns, the place of a marker on it is determined so loosely that undamped steps leave the range of
any linearisation.

    γ_g = Σ_(i in g) (1 − C_ii/d_i²),   f_g² = Σ (θ_i/δ_i)²/γ_g,   s² = |r|²/(M − Σγ − rank of what has no factor),

d_i = f_g·δ_i being the prior deviation of parameter i and C the posterior covariance.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.estimation.descent import Descent, Linearised

_TURNS = 12
_FIXED = 30
_COARSE, _FINE = 1e-3, 1e-9
"""Relative fall of the cost in one step at which parameters have settled, between changes of the factors and after."""
_SETTLED = 2e-2
"""Change of the logarithm of a factor at which it has settled."""
_ALONE = 1.0 + 1e-9
"""Diagonal of I − H, so that a reading that nothing else predicts leaves it regular."""


@dataclass(frozen=True)
class Priors:
    """What is known beforehand.

    Attributes:
        mean, deviation: of every parameter, shape (p,); infinite where nothing is known.
        group: of every parameter, shape (p,); −1 where the deviation stays as it is.
        low, high: bounds, shape (p,).
    """

    mean: FloatArray
    deviation: FloatArray
    group: IntArray
    low: FloatArray
    high: FloatArray


@dataclass(frozen=True)
class Sized:
    """Parameters fitted with the sizes of their groups.

    Attributes:
        values: shape (p,).
        covariance: with the noise as it was learnt, shape (p, p).
        factors: of the groups.
        determined: γ_g, how many parameters of each group the data determine.
        noise: standard deviation of the whitened residuals.
        residuals, slopes: at the values, shapes (M,) and (M, p).
    """

    values: FloatArray
    covariance: FloatArray
    factors: FloatArray
    determined: FloatArray
    noise: float
    residuals: FloatArray
    slopes: FloatArray

    def left_out(self, blocks: IntArray, priors: Priors) -> FloatArray:
        """Errors of readings predicted without their block, e_B = (I − H_BB)⁻¹·r_B of the linear problem, (M,)."""
        gram = self.slopes.T @ self.slopes
        _, _, root = inverse(gram, prior_precision(priors, self.factors, self.noise))
        projected = self.slopes @ root
        errors = np.empty_like(self.residuals)
        for block in np.unique(blocks):
            inside = np.flatnonzero(blocks == block)
            own = projected[inside]
            errors[inside] = np.linalg.solve(_ALONE * np.eye(len(inside)) - own @ own.T, self.residuals[inside])
        return errors


def with_evidence(
    linearised: Linearised,
    priors: Priors,
    start: FloatArray,
    *,
    known_noise: bool = True,
    least: float,
    most: float,
) -> Sized:
    """Parameters, factors of the groups of priors and noise.

    Args:
        linearised: residuals and derivatives.
        priors: what is known beforehand.
        start: parameters to start from, shape (p,).
        known_noise: whether the noise is 1.
        least: smallest factor.
        most: largest factor.
    """
    descent = Descent(linearised, start, priors.mean, priors.low, priors.high)
    count = max(int(priors.group.max(initial=-1)) + 1, 1)
    factors: FloatArray = np.ones(count)
    determined: FloatArray = np.zeros(count)
    noise = 1.0
    for _ in range(_TURNS):
        descent.run(prior_precision(priors, factors, noise), *_ends(_COARSE))
        before: FloatArray = factors
        factors, determined, noise = _decided(
            descent, priors, before, noise, known_noise=known_noise, ends=(least, most)
        )
        if np.abs(np.log(factors / before)).max() < _SETTLED:
            break
    precision = prior_precision(priors, factors, noise)
    descent.run(precision, *_ends(_FINE))
    residuals, slopes = descent.residuals, descent.slopes
    covariance = noise**2 * inverse(slopes.T @ slopes, precision)[0]
    return Sized(descent.values, covariance, factors, determined, noise, residuals, slopes)


def _ends(share: float) -> tuple[Callable[[float], float], float]:
    """When a descent ends: where a step gains less than a share of the cost, or promises a thousandth of that."""
    return lambda cost: share * cost, 1e-3


def _decided(
    descent: Descent, priors: Priors, factors: FloatArray, noise: float, *, known_noise: bool, ends: tuple[float, float]
) -> tuple[FloatArray, FloatArray, float]:
    """Factors, how many parameters of each group are determined, and noise, on the problem linearised here."""
    slopes = descent.slopes
    readings = descent.residuals + slopes @ (descent.values - priors.mean)
    gram, right = slopes.T @ slopes, slopes.T @ readings
    factors, determined = factors.copy(), np.zeros(len(factors))
    for _ in range(_FIXED):
        before = factors.copy()
        precision = prior_precision(priors, factors, noise)
        covariance, variances, _ = inverse(gram, precision)
        step, gamma = covariance @ right, 1.0 - variances * precision
        for group in range(len(factors)):
            own: BoolArray = priors.group == group
            if own.any():
                determined[group] = max(float(gamma[own].sum()), 1e-9)
                size = float(((step / priors.deviation)[own] ** 2).sum())
                factors[group] = np.clip(np.sqrt(size / determined[group]), *ends)
        if not known_noise:
            left = readings - slopes @ step
            noise = float(np.sqrt(left @ left / max(len(left) - gamma.sum(), 1.0)))
        if np.abs(np.log(factors / before)).max() < _SETTLED / 2.0:
            break
    return factors, determined, noise


def prior_precision(priors: Priors, factors: FloatArray, noise: float) -> FloatArray:
    """Prior precisions in units of the noise, shape (p,)."""
    # Without any group there are no factors.
    scale = np.where(priors.group >= 0, np.append(factors, 1.0)[priors.group], 1.0)
    precision: FloatArray = (noise / (scale * priors.deviation)) ** 2
    return precision


def inverse(gram: FloatArray, precision: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(G + P)⁻¹, its diagonal and its root; what neither readings nor priors determine is left at 0."""
    matrix = gram + np.diag(precision)
    scale = 1.0 / np.sqrt(np.maximum(matrix.diagonal(), 1e-300))
    values, vectors = np.linalg.eigh(matrix * np.outer(scale, scale))
    kept = values > 1e-14 * values[-1]
    root = vectors[:, kept] / np.sqrt(values[kept]) * scale[:, None]
    return root @ root.T, (root**2).sum(axis=1), root
