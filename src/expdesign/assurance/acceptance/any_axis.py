"""The probability that any of several axes is beyond its tolerance, from that of each and how their errors go together.

No axis alone says it: the probability lies between that of the likeliest axis and the sum over all (Boole). With d axes
whose errors are jointly normal, each side of each axis is a half-space H_j, j = 1 … 2d, of probability P_j, and their
union has the probability (Owen, Maximov and Chertkov, Electronic Journal of Statistics 13, 2019, 231: ALOE)

    P(H_1 ∪ … ∪ H_2d) = Σ_j P_j · E[1/S(x)],  x ~ Σ_j P_j·N(· | H_j) / Σ_j P_j,

S(x) being the number of half-spaces that x is in. The estimate lies within Boole's bounds however rare the event is;
with N draws its relative standard error is at most √((ΣP_j/P − 1)/N), some per cent at worst.
"""

import numpy as np
from scipy.special import ndtri

from expdesign.arrays import FloatArray

NEGLIGIBLE = 1e-9
"""Sum of the axes' probabilities below which that sum, an upper bound, stands for the union."""
DRAWS = 1024
"""Of every union, from one fixed seed: the same recordings are decided alike."""


def any_beyond(above: FloatArray, below: FloatArray, covariance: FloatArray, negligible: float = NEGLIGIBLE) -> float:
    """Probability that any of d axes is beyond its tolerance.

    Args:
        above: probability of each error to exceed its tolerance upwards, shape (d,).
        below: downwards, shape (d,).
        covariance: of the errors in any unit, shape (d, d). Errors that are not normal count as normal in the scores
            that have these probabilities (a Gaussian copula).
        negligible: sum of the probabilities below which that sum, an upper bound, stands for the union.
    """
    alone = np.concatenate([above, below])
    total = float(alone.sum())
    if total < negligible:
        return min(total, 1.0)
    deviation = np.sqrt(np.diag(covariance))
    unit = np.where(deviation > 0.0, deviation, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(unit, unit))
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    generator, draws = np.random.default_rng(0), DRAWS
    # Every half-space in proportion to its probability, with the least scatter: systematic sampling.
    drawn = np.searchsorted(np.cumsum(alone), total * (np.arange(draws) + 0.5) / draws).clip(max=len(alone) - 1)
    axis, sign = drawn % len(above), np.where(drawn < len(above), 1.0, -1.0)
    score = -sign * ndtri(alone[drawn] * generator.uniform(size=draws))
    errors = generator.standard_normal((draws, len(above))) @ root.T
    rows = np.arange(draws)
    # Given one error, the others follow it by regression: that error is what it is conditioned to be.
    errors += (score - errors[rows, axis])[:, None] * (root @ root.T)[axis]
    beyond = np.concatenate([errors > -ndtri(above), errors < ndtri(below)], axis=1)
    beyond[rows, drawn] = True
    union = total * float((1.0 / beyond.sum(axis=1)).mean())
    return float(np.clip(union, (above + below).max(), min(total, 1.0)))
