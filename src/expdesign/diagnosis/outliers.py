"""Single recordings that belong to no physics: which rows stand out, and whether they stand out alone."""

import numpy as np
from scipy.stats import chi2 as chi2_distribution

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.diagnosis.score import orthonormal_basis
from expdesign.identification.fit import Fit

_SHUFFLES = 2000
_ISOLATED = 0.005
"""Probability below which rows set aside have too much in common for single mistakes."""
_FEWEST = 3


def row_distances(result: Fit) -> FloatArray:
    """Reduction of χ² if a row were left out, shape (N,): r·(I − H)⁻¹·r with H the row's own leverage."""
    rows, readings, width = result.sensitivities.shape
    basis = orthonormal_basis(result.sensitivities.reshape(-1, width)).reshape(rows, readings, -1)
    remaining = np.eye(readings) - np.einsum("nkr,nlr->nkl", basis, basis)
    remaining += 1e-9 * np.eye(readings)
    solved = np.linalg.solve(remaining, result.residuals[..., None])[..., 0]
    distances: FloatArray = np.einsum("nk,nk->n", result.residuals, solved)
    return distances


def isolated(residuals: FloatArray, outliers: BoolArray, series: IntArray) -> bool:
    """Whether rows set aside are single mistakes: of no common direction, and in no common series.

    Args:
        residuals: whitened residuals of all rows under the model that was fitted without the outliers, shape (N, k).
        outliers: the rows set aside, shape (N,).
        series: of every row, shape (N,).
    """
    chosen = np.flatnonzero(outliers)
    if chosen.size < _FEWEST:
        return True
    directions = residuals[chosen] / np.linalg.norm(residuals[chosen], axis=1, keepdims=True)
    width = directions.shape[1]
    resultant = float((directions.sum(axis=0) ** 2).sum()) * width / chosen.size
    if chi2_distribution.sf(resultant, width) < _ISOLATED:
        return False
    generator = np.random.default_rng(0)
    observed = _pairs(series[chosen])
    shuffled = [_pairs(series[generator.permutation(len(series))[: chosen.size]]) for _ in range(_SHUFFLES)]
    return float(np.mean(np.array(shuffled) >= observed)) >= _ISOLATED


def _pairs(series: IntArray) -> int:
    """Number of pairs of rows that share a series."""
    counts = np.unique(series, return_counts=True)[1]
    return int((counts * (counts - 1)).sum()) // 2
