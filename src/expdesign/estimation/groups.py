"""Least squares with normal priors by groups, whose variances the readings decide by their restricted likelihood.

Parameters of one group are errors of one kind: θ_i ~ N(m_i, (f_g·δ_i)²) with δ_i as such things are made. The factors
are those of the greatest posterior density, with ln f_g ~ N(0, s²): on the problem linearised at the parameters
(`gaussian.py`)

    ∂/∂ln f_g = |u_g|² − γ_g − ln f_g/s²,   ∂/∂ln σ = |e|²/σ² + Σγ + rank − M,

u_g being the group's parameters in units of f_g·δ_i, γ_g how many of them the readings determine, and σ the noise
where it is not known (MacKay, Neural Computation 4, 1992, 415; Patterson and Thompson, Biometrika 58, 1971, 545). So a
group in which nothing is wrong is held at the drawing by the readings themselves, and one that is wrong everywhere is
free. Damped steps (`descent.py`) find the parameters; both take turns until the factors stay.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import minimize

from expdesign.arrays import FloatArray, IntArray
from expdesign.estimation.descent import Descent, Linearised
from expdesign.estimation.gaussian import Gaussian

_TURNS = 12
_COARSE, _FINE = 1e-3, 1e-9
"""Relative fall of the cost in one step at which parameters have settled, between changes of the factors and after."""
_SETTLED = 2e-2
"""Change of the logarithm of a factor at which it has settled."""
_FARTHEST = 12.0
"""Logarithm of factors and noise at which the search for them ends."""


@dataclass(frozen=True)
class Priors:
    """What is known beforehand.

    Attributes:
        mean, deviation: of every parameter, shape (p,); infinite where nothing is known.
        group: of every parameter, shape (p,); −1 where the deviation stays as it is.
        low, high: bounds, shape (p,).
        groups: how many there are, those without a parameter included.
        spread: s, standard deviation of the logarithm of a factor.
    """

    mean: FloatArray
    deviation: FloatArray
    group: IntArray
    low: FloatArray
    high: FloatArray
    groups: int = 0
    spread: float = np.inf

    def deviations(self, factors: FloatArray) -> FloatArray:
        """f_g·δ_i, shape (p,)."""
        scaled: FloatArray = self.deviation * np.where(self.group >= 0, np.append(factors, 1.0)[self.group], 1.0)
        return scaled

    def model(self, factors: FloatArray, columns: FloatArray, readings: FloatArray) -> Gaussian:
        """The linear problem, its parameters relative to their means."""
        return Gaussian(columns, readings, self.deviations(factors))

    def by_group(self, values: FloatArray) -> FloatArray:
        """Sums over the parameters of each group of what stands for all with a deviation (s,), shape (g,)."""
        own = self.group[np.isfinite(self.deviation)]
        return np.bincount(own[own >= 0], values[own >= 0], self.groups).astype(float)


@dataclass(frozen=True)
class Sized:
    """Parameters fitted with the sizes of their groups.

    Attributes:
        priors: of the parameters.
        values: shape (p,).
        factors: of the groups.
        determined: γ_g, how many parameters of each group the data determine.
        noise: standard deviation of the whitened residuals.
        residuals, slopes: at the values, shapes (M,) and (M, p).
    """

    priors: Priors
    values: FloatArray
    factors: FloatArray
    determined: FloatArray
    noise: float
    residuals: FloatArray
    slopes: FloatArray

    @cached_property
    def covariance(self) -> FloatArray:
        """With the noise as it was learnt, shape (p, p)."""
        model = self.priors.model(self.factors, self.slopes / self.noise, self.residuals)
        return model.estimable.generalised

    def left_out(self, blocks: IntArray) -> FloatArray:
        """Errors of whitened readings predicted without their block (M,), by the linear problem; see `Gaussian`."""
        readings = (self.residuals + self.slopes @ (self.values - self.priors.mean)) / self.noise
        return self.noise * self.priors.model(self.factors, self.slopes / self.noise, readings).left_out(blocks)


def with_groups(linearised: Linearised, priors: Priors, start: FloatArray, *, known_noise: bool = True) -> Sized:
    """Parameters, factors of the groups of priors and noise.

    Args:
        linearised: residuals and derivatives.
        priors: what is known beforehand.
        start: parameters to start from, shape (p,).
        known_noise: whether the noise is 1.
    """
    descent = Descent(linearised, start, priors.mean, priors.low, priors.high)
    factors: FloatArray = np.ones(priors.groups)
    noise = 1.0
    for _ in range(_TURNS):
        descent.run((noise / priors.deviations(factors)) ** 2, *_ends(_COARSE))
        if not priors.groups and known_noise:
            break
        before = factors
        factors, noise = _decided(descent, priors, factors, noise, known_noise=known_noise)
        if np.abs(np.log(factors / before)).max(initial=0.0) < _SETTLED:
            break
    descent.run((noise / priors.deviations(factors)) ** 2, *_ends(_FINE))
    determined = priors.by_group(priors.model(factors, descent.slopes / noise, descent.residuals).determined)
    return Sized(priors, descent.values, factors, determined, noise, descent.residuals, descent.slopes)


def _ends(share: float) -> tuple[Callable[[float], float], float]:
    """When a descent ends: where a step gains less than a share of the cost, or promises a thousandth of that."""
    return lambda cost: share * cost, 1e-3


def _decided(
    descent: Descent, priors: Priors, factors: FloatArray, noise: float, *, known_noise: bool
) -> tuple[FloatArray, float]:
    """Factors and noise of the greatest posterior density, on the problem linearised here."""
    count = len(descent.residuals)
    readings = descent.residuals + descent.slopes @ (descent.values - priors.mean)
    whole = np.column_stack([descent.slopes, readings])
    if len(whole) > whole.shape[1]:
        whole = np.asarray(np.linalg.qr(whole, mode="r"))  # as small as the problem

    def misfit(logs: FloatArray) -> tuple[float, FloatArray]:
        sizes, level = np.exp(logs[:-1]), float(np.exp(logs[-1]))
        model = priors.model(sizes, whole[:, :-1] / level, whole[:, -1] / level)
        determined, squares = model.determined, model.standardised**2
        slopes = priors.by_group(squares - determined)
        left = model.chi2 - float((squares - determined).sum()) + model.rank - count
        away = logs[:-1] / priors.spread**2
        value = model.log_evidence - count * logs[-1] - 0.5 * float(away @ logs[:-1])
        return -value, -np.append(slopes - away, left)

    start = np.append(np.log(factors), np.log(noise))
    farthest = np.where(np.arange(len(start)) < priors.groups, _FARTHEST, 0.0 if known_noise else np.inf)
    found = minimize(misfit, start, jac=True, method="L-BFGS-B", bounds=list(zip(-farthest, farthest, strict=True)))
    sizes: FloatArray = np.exp(found.x[:-1])
    return sizes, float(np.exp(found.x[-1]))
