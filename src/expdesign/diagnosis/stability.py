"""How often the same effects are named when a tenth of the rows is left out (stability selection).

For every tenth the model is fitted to the other nine, linear about its fit to all, and an effect is named where what it
explains there is worth its price as in the search. With C the covariance of the parameters on those rows and d what the
effect's own differ from doing nothing by, the sum of squares without it is larger by dᵀ·C_kk⁻¹·d. Meinshausen and
Bühlmann, Journal of the Royal Statistical Society B 72 (2010) 417, judge names by such shares; they draw halves.
"""

from collections.abc import Hashable, Sequence, Set
from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, as_matrix
from expdesign.diagnosis.cross_validation import blocks_of, readings_of
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.selection import Model, Search


@dataclass(frozen=True)
class Stability:
    """Shares of the refits.

    Attributes:
        refits: their number.
        same: share that names all the effects.
        shares: of each effect of the model, in its order: that it is named.
    """

    refits: int
    same: float
    shares: tuple[float, ...]


def stability(search: Search, model: Model) -> Stability | None:
    """Shares of the refits that name the effects of a model; None where it has none, or a tenth holds no row."""
    if not model.candidates:
        return None
    sample = search.sample.restricted(~model.outliers)
    blocks = blocks_of(sample, OPTIONS.refits)
    if len(np.unique(blocks[sample.counts])) < OPTIONS.refits:
        return None
    owner, kept = readings_of(blocks, sample), sample.kept
    slopes, residuals = as_matrix(model.fit.sensitivities)[kept], model.fit.residuals.ravel()[kept]
    refits = [_named(search, model, slopes[owner != tenth], residuals[owner != tenth]) for tenth in np.unique(owner)]
    return shares_of(range(len(model.candidates)), refits)


def shares_of(names: Sequence[Hashable], refits: Sequence[Set[Hashable]]) -> Stability:
    """Shares of refits that name each of some names, and all of them."""
    shares = tuple(float(np.mean([name in refit for refit in refits])) for name in names)
    return Stability(len(refits), float(np.mean([set(names) <= refit for refit in refits])), shares)


def _named(search: Search, model: Model, slopes: FloatArray, residuals: FloatArray) -> set[int]:
    """Numbers of the effects that are worth their price on these readings."""
    chain, values, readings = model.fit.chain, model.fit.values, len(residuals)
    scales = chain.scales()
    known = chain.knowledge()
    mean, precision = (values, np.zeros(len(values))) if known is None else (known[0], (scales / known[1]) ** 2)
    scaled = slopes * scales
    right = scaled.T @ residuals + precision * (mean - values) / scales
    covariance = np.linalg.pinv(scaled.T @ scaled + np.diag(precision), rcond=1e-12, hermitian=True)
    step = covariance @ right
    left = max(float(residuals @ residuals - right @ step), 1e-300)
    named = set()
    for number, (candidate, part) in enumerate(zip(model.candidates, chain.slices, strict=True)):
        effect = candidate.effect
        free: BoolArray = np.array([not p.shape for p in effect.parameters])
        own = np.arange(part.start, part.stop)[free]
        away = step[own] + (values[own] - effect.neutral()[free]) / scales[own]
        gain = float(away @ np.linalg.pinv(covariance[np.ix_(own, own)], hermitian=True) @ away)
        fall = gain if search.known_noise else readings * float(np.log1p(gain / left))
        if fall - search.price(candidate, readings) >= OPTIONS.acceptance:
            named.add(number)
    return named
