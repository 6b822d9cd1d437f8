"""How well each criterion foretells the accuracy that is attained: rank correlation over designs."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import rankdata

from expdesign.arrays import FloatArray
from expdesign.assurance.comparison.judgement import Judgement

_STREAM = 13
"""Keeps the bootstrap apart from other numbers of the same seed."""


@dataclass(frozen=True)
class RankCorrelation:
    """Spearman's coefficient of a criterion with the attained accuracy.

    Attributes:
        criterion: its name.
        over: which designs.
        designs: how many.
        coefficient: 1 where the criterion puts the designs in the order of their accuracy, −1 in the reverse order.
        low, high: its 95 % interval, by resampling the designs.
    """

    criterion: str
    over: str
    designs: int
    coefficient: float
    low: float
    high: float


def rank_correlations(judgement: Judgement, seed: int) -> list[RankCorrelation]:
    """Of every criterion, over all designs and over the random ones, which no criterion has picked."""
    attained = judgement.attained
    origins = np.array([contender.origin for contender in judgement.contenders])
    found = []
    for over, chosen in (("all designs", np.ones(len(origins), dtype=bool)), ("random designs", origins == "random")):
        for name, values in judgement.values.items():
            goodness = values if judgement.problem.criteria[name].maximise else -values
            kept = chosen & np.isfinite(goodness) & np.isfinite(attained)
            if kept.sum() >= 4:
                generator = np.random.default_rng([seed, _STREAM])
                found.append(_correlation(name, over, goodness[kept], -attained[kept], generator))
    return found


def spearman(first: FloatArray, second: FloatArray) -> FloatArray:
    """Spearman's coefficient of rows (..., d), ties sharing their mean rank; NaN where one of them does not vary."""
    a, b = (rankdata(values, axis=-1) for values in (first, second))
    a, b = (ranks - ranks.mean(axis=-1, keepdims=True) for ranks in (a, b))
    with np.errstate(divide="ignore", invalid="ignore"):
        return (a * b).sum(axis=-1) / np.sqrt((a**2).sum(axis=-1) * (b**2).sum(axis=-1))


def _correlation(
    name: str, over: str, goodness: FloatArray, accuracy: FloatArray, generator: np.random.Generator
) -> RankCorrelation:
    count = len(goodness)
    rows = generator.integers(count, size=(2000, count))
    resampled = spearman(goodness[rows], accuracy[rows])
    resampled = resampled[np.isfinite(resampled)]
    low, high = np.quantile(resampled, (0.025, 0.975)) if resampled.size else (np.nan, np.nan)
    return RankCorrelation(name, over, count, float(spearman(goodness, accuracy)), float(low), float(high))
