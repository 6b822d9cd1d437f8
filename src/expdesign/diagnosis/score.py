"""Score tests: how much of the residuals an effect could explain, to first order, before anything is fitted."""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray

_NEGLIGIBLE = 1e-8
"""Directions of which the model already explains all but this fraction carry no information."""


@dataclass(frozen=True)
class Score:
    """Result of a score test.

    Attributes:
        statistic: reduction of χ² by the best linear combination of the directions.
        dimension: number of independent directions used.
        start: index of the start with the largest statistic.
        step: the parameters of that combination, shape (d,).
    """

    statistic: float
    dimension: int
    start: int
    step: FloatArray


def orthonormal_basis(sensitivities: FloatArray) -> FloatArray:
    """FeatureBasis (M, r) of the space spanned by whitened sensitivities (M, p)."""
    norms = np.linalg.norm(sensitivities, axis=0)
    scaled = sensitivities[:, norms > 0.0] / norms[norms > 0.0]
    left, values, _ = np.linalg.svd(scaled, full_matrices=False)
    basis: FloatArray = left[:, values > 1e-9 * values[:1]]
    return basis


def score(residuals: FloatArray, basis: FloatArray, directions: FloatArray, one_sided: BoolArray) -> Score:
    """Score test of directions (G, M, d) on residuals (M,) after projecting out a model with the given basis (M, r).

    A direction that may only be followed one way counts nothing when the residuals point the other way; with several
    directions, those that would turn negative are dropped (an approximation of the constrained maximum).
    """
    free = directions - basis @ (basis.T @ directions)
    gram = np.matmul(free.swapaxes(1, 2), free)
    whole = (directions**2).sum(axis=1)
    slope = residuals @ free
    if not one_sided.any():
        return _best_of_all(gram, whole, slope)
    best = Score(0.0, 0, 0, np.zeros(gram.shape[2]))
    for start in range(len(gram)):
        kept = gram[start].diagonal() > _NEGLIGIBLE * whole[start]
        while kept.any():
            step, rank = _solve(gram[start][np.ix_(kept, kept)], slope[start][kept])
            wrong = np.zeros_like(kept)
            wrong[np.flatnonzero(kept)] = one_sided[kept] & (step < 0.0)
            if not wrong.any():
                statistic = float(step @ slope[start][kept])
                if statistic > best.statistic:
                    full = np.zeros(gram.shape[2])
                    full[kept] = step
                    best = Score(statistic, rank, start, full)
                break
            kept &= ~wrong
    return best


def _best_of_all(gram: FloatArray, whole: FloatArray, slope: FloatArray) -> Score:
    """The best start of directions without constraints: gram (G, d, d), squared norms before projection and slopes
    (G, d).
    """
    diagonal = np.diagonal(gram, axis1=1, axis2=2)
    kept = diagonal > _NEGLIGIBLE * whole
    scale = np.where(kept, np.sqrt(np.where(kept, diagonal, 1.0)), np.inf)
    values, vectors = np.linalg.eigh(gram / (scale[:, :, None] * scale[:, None, :]))
    used = (values > 1e-7 * values[:, -1:]) & (values > 0.0)
    rotated = np.einsum("gdk,gd->gk", vectors, slope / scale)
    weights = np.where(used, rotated / np.where(used, values, 1.0), 0.0)
    statistics = (rotated * weights).sum(axis=1)
    start = int(np.argmax(statistics))
    step = (vectors[start] @ weights[start]) / scale[start]
    return Score(float(statistics[start]), int(used[start].sum()), start, step)


def _solve(gram: FloatArray, slope: FloatArray) -> tuple[FloatArray, int]:
    scale = np.sqrt(gram.diagonal())
    values, vectors = np.linalg.eigh(gram / np.outer(scale, scale))
    kept = values > 1e-7 * values[-1]
    rotated = vectors[:, kept].T @ (slope / scale)
    return (vectors[:, kept] @ (rotated / values[kept])) / scale, int(kept.sum())
