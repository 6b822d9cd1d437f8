"""Single recordings that belong to no physics: which rows stand out, and whether they stand out alone."""

import numpy as np
from scipy.stats import binom, rankdata
from scipy.stats import chi2 as chi2_distribution

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.diagnosis.evidence.state import Present
from expdesign.diagnosis.options import OPTIONS
from expdesign.estimation.fit import Data, Fit

_SHUFFLES = 2000
_TESTS = 4
"""Of what rows set aside have in common."""
_FEWEST = 3

_ROUNDING = 1e-9
"""What is left of a reading that nothing else predicts."""


def row_distances(
    residuals: FloatArray, slopes: FloatArray, known: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Fall of χ² without each row (N,), I − Hᵢ (N, k, k) and Sᵢ·P (N, k, p).

    Args:
        residuals: whitened, shape (N, k).
        slopes: whitened derivatives of the prediction, shape (N, k, p).
        known: P, covariance of the parameters, shape (p, p).
    """
    spread = slopes @ known
    room = (1.0 + _ROUNDING) * np.eye(residuals.shape[1]) - spread @ slopes.swapaxes(1, 2)
    distances: FloatArray = np.einsum("nk,nk->n", residuals, np.linalg.solve(room, residuals[..., None])[..., 0])
    return distances, room, spread


def standing_out(result: Fit, aside: BoolArray, price: float, most: int, readings: int | None = None) -> BoolArray:
    """Rows that are set aside, the one that stands out most first, each without those before it, shape (N,).

    Linear about the fit: without row i the parameters move by −P·Sᵢᵀ·(I − Hᵢ)⁻¹·rᵢ with Hᵢ = Sᵢ·P·Sᵢᵀ, and χ² falls by
    rᵢᵀ·(I − Hᵢ)⁻¹·rᵢ.

    Args:
        result: of the rows that are not `aside`.
        aside: rows that were set aside, shape (N,).
        price: fall of χ², in variances of the noise, that a row has to bring.
        most: rows that may be aside.
        readings: number of those of which χ² is, where their noise is not known; it then is what remains.
    """
    residuals, slopes = result.residuals.copy(), result.sensitivities.copy()
    known, flagged = result.estimable.generalised / result.inflation, aside.copy()
    while int(flagged.sum()) < most:
        distances, room, spread = row_distances(residuals, slopes, known)
        worst = int(np.argmax(distances))
        variance = 1.0 if readings is None else float((residuals**2).sum()) / max(readings, 1)
        if distances[worst] < price * variance:
            break
        flagged[worst] = True
        gain = np.linalg.solve(room[worst], spread[worst]).T
        residuals += slopes @ (gain @ residuals[worst])
        known = known + gain @ spread[worst]
        residuals[worst], slopes[worst] = 0.0, 0.0
    return flagged


def returning_distances(result: Fit, sample: Data, outliers: BoolArray) -> FloatArray:
    """Growth of χ² if a row set aside counted again, shape (N,): r·(I + S·P·Sᵀ)⁻¹·r; 0 for all other rows."""
    everything = sample.counting(sample.counts)
    residuals, slopes = everything.residuals_with_sensitivities(result.chain, result.values)
    known = np.where(np.isfinite(result.covariance), result.covariance, 0.0)
    distances = np.zeros(len(outliers))
    for row in np.flatnonzero(outliers):
        spread = np.eye(residuals.shape[1]) + slopes[row] @ known @ slopes[row].T
        distances[row] = float(residuals[row] @ np.linalg.solve(spread, residuals[row]))
    return distances


def outlier_price(readings: int, axes: int, rows: int) -> float:
    """Reduction of χ² that a row set aside is worth: a parameter for each reading of it, in any of the rows."""
    return float(axes * np.log(max(readings, 2)) + 2.0 * np.log(max(rows, 2)))


def single_mistakes(state: Present, row_of: IntArray, axes: int) -> IntArray:
    """Rows that a model does not explain, worst first: each is left out before the next is judged.

    None where they would be more than single mistakes are: then something is missing.

    Args:
        state: the model, to first order.
        row_of: row of every reading, shape (M,).
        axes: readings of a row.
    """
    rows = len(np.unique(row_of))
    price, most = outlier_price(len(row_of), axes, rows), max(1, int(OPTIONS.single_mistakes * rows))
    aside: list[int] = []
    while len(aside) <= most:
        sizes = state.projected * state.left_out(row_of) / state.noise_variance
        distances = np.bincount(row_of, weights=sizes)
        worst = int(np.argmax(distances))
        if distances[worst] < price:
            return np.array(aside, dtype=np.int64)
        aside.append(worst)
        state, row_of = state.of_rows(row_of != worst), row_of[row_of != worst]
    return np.zeros(0, dtype=np.int64)


def in_common(residuals: FloatArray, outliers: BoolArray, series: IntArray, drivers: dict[str, FloatArray]) -> str:
    """What rows set aside have in common that single mistakes do not; empty where there is nothing.

    Single mistakes are few, and happen at random: in any direction, in any series, at any pose, load and time. The last
    is tested by the ranks of the rows set aside in every driver, and by how far these lie from the middle; the largest
    of all these statistics is compared with those of rows drawn at random, which keeps the level whatever the drivers.

    Args:
        residuals: whitened residuals of all rows under the model that was fitted without the outliers, shape (N, k).
        outliers: the rows set aside, shape (N,).
        series: of every row, shape (N,).
        drivers: quantities of which mistakes are independent, shape (N,) each.
    """
    chosen = np.flatnonzero(outliers)
    count, rows = chosen.size, len(outliers)
    if count < _FEWEST:
        return ""
    if binom.sf(count - 1, rows, OPTIONS.remainder) < OPTIONS.level / _TESTS:
        return "they are too many"
    directions = residuals[chosen] / np.linalg.norm(residuals[chosen], axis=1, keepdims=True)
    width = directions.shape[1]
    resultant = float((directions.sum(axis=0) ** 2).sum()) * width / count
    if chi2_distribution.sf(resultant, width) < OPTIONS.level / _TESTS:
        return "they point the same way"
    generator = np.random.default_rng(0)
    draws = [generator.permutation(rows)[:count] for _ in range(_SHUFFLES)]
    if np.mean([_pairs(series[draw]) >= _pairs(series[chosen]) for draw in draws]) < OPTIONS.level / _TESTS:
        return "they are of the same series"
    if drivers:
        scores = _rank_scores(drivers)
        observed = np.abs(scores[:, chosen].sum(axis=1))
        usual = np.abs(scores[:, np.array(draws)].sum(axis=2)).max(axis=0)
        if np.mean(usual >= observed.max()) < OPTIONS.level / _TESTS:
            return f"they depend on {list(drivers)[int(np.argmax(observed)) % len(drivers)]}"
    return ""


def _rank_scores(drivers: dict[str, FloatArray]) -> FloatArray:
    """Standardised ranks of every driver, and of its distance from its median, shape (2d, N)."""
    values = np.array(list(drivers.values()))
    distances = np.abs(values - np.median(values, axis=1, keepdims=True))
    ranks = rankdata(np.concatenate([values, distances]), axis=1)
    centred = ranks - ranks.mean(axis=1, keepdims=True)
    deviations = centred.std(axis=1, keepdims=True)
    scores: FloatArray = centred / np.where(deviations > 0.0, deviations, 1.0)
    return scores


def _pairs(series: IntArray) -> int:
    """Number of pairs of rows that share a series."""
    counts = np.unique(series, return_counts=True)[1]
    return int((counts * (counts - 1)).sum()) // 2
