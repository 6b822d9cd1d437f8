"""Single recordings that belong to no physics: which rows stand out, and whether they stand out alone."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.special import bdtrc, chdtrc

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.diagnosis.evidence.state import Present
from expdesign.diagnosis.locate import drivers
from expdesign.diagnosis.options import OPTIONS
from expdesign.estimation.fit import Data, Fit
from expdesign.mechanics.robots.robot import Robot

_SHUFFLES = 2000
_TESTS = 4
"""Of what rows set aside have in common."""
_FEWEST = 3

_ROUNDING = 1e-9
"""What is left of a reading that nothing else predicts."""


@dataclass(frozen=True)
class Mistakes:
    """Rows that stand out of a model as single mistakes do.

    Attributes:
        rows: set aside, shape (N,); none where those that stand out are no mistakes.
        common: what these have in common; empty where they have nothing.
        worth: log evidence that the model gains without the rows set aside, each at its price.
    """

    rows: BoolArray
    common: str = ""
    worth: float = 0.0


def standing_out(state: Present, axes: int, most: int) -> tuple[IntArray, float]:
    """Rows that a model does not explain, the one that stands out most first, each without those before it.

    And the log evidence that the model gains without them, at their price.

    With P = I − F·Fᵀ (`state`), Hᵢ = Fᵢ·Fᵢᵀ and r = P·y, yᵀPy falls by rᵢᵀ·(I − Hᵢ)⁻¹·rᵢ without row i, which leaves
    r + F·Fᵢᵀ·(I − Hᵢ)⁻¹·rᵢ. A row stands out whose fall exceeds `outlier_price`, in variances of the noise; where that
    is not known it is what remains.

    Args:
        state: the model, to first order.
        axes: readings of a row.
        most: rows that are looked for at most.
    """
    residuals = state.projected.reshape(-1, axes)
    rows = len(residuals)
    factor = state.factor.reshape(rows, axes, -1)
    spread, aside, scatter = factor.copy(), list[int](), state.scatter
    price = outlier_price(len(state.readings), axes, rows)
    while len(aside) < most:
        room = (1.0 + _ROUNDING) * np.eye(axes) - spread @ factor.swapaxes(1, 2)
        falls = np.einsum("nk,nk->n", residuals, np.linalg.solve(room, residuals[..., None])[..., 0])
        falls[aside] = 0.0
        worst = int(np.argmax(falls))
        if falls[worst] < price * (1.0 if state.known_noise else scatter / state.freedom):
            break
        aside.append(worst)
        scatter -= falls[worst]
        gain = np.linalg.solve(room[worst], spread[worst])
        moved = spread @ factor[worst].T
        residuals = residuals + moved @ np.linalg.solve(room[worst], residuals[worst])
        spread = spread + moved @ gain
    fall = state.scatter - scatter
    worth = fall if state.known_noise else state.freedom * float(np.log(state.scatter / scatter))
    return np.array(aside, dtype=np.int64), 0.5 * (worth - len(aside) * price)


def returning(result: Fit, sample: Data, aside: BoolArray, *, known_noise: bool) -> BoolArray:
    """Rows set aside (N,) that a model fitted without them explains after all, shape (N,).

    χ² grows by r·(I + S·P·Sᵀ)⁻¹·r if such a row counts again, which is less than `outlier_price`.
    """
    price = outlier_price(sample.readings, len(sample.recordings.axes), int(sample.counts.sum()))
    variance = 1.0 if known_noise else max(result.chi2 / max(sample.restricted(~aside).readings, 1), 1e-300)
    residuals, slopes = sample.residuals_with_sensitivities(result.chain, result.values)
    known = np.where(np.isfinite(result.covariance), result.covariance, 0.0)
    spread = np.eye(residuals.shape[1]) + slopes @ known @ slopes.swapaxes(1, 2)
    growth = (residuals * np.linalg.solve(spread, residuals[..., None])[..., 0]).sum(axis=1)
    found: BoolArray = aside & (growth < price * variance)
    return found


def outlier_price(readings: int, axes: int, rows: int) -> float:
    """Reduction of χ² that a row set aside is worth: a parameter for each reading of it, in any of the rows."""
    return float(axes * np.log(max(readings, 2)) + 2.0 * np.log(max(rows, 2)))


def single_mistakes(state: Present, sample: Data, robot: Robot) -> Mistakes:
    """Rows that stand out of a model as single mistakes do, or none and why those that do are no mistakes.

    Args:
        state: the model, to first order, in the rows that count.
        sample: these rows.
        robot: the robot.
    """
    rows, axes = np.flatnonzero(sample.counts), len(sample.recordings.axes)
    most = min(max(1, len(rows) // 10), len(rows) - 1)  # one has to stay
    out: BoolArray = np.zeros(len(rows), dtype=bool)
    chosen, worth = standing_out(state, axes, most)
    out[chosen] = True
    aside: BoolArray = np.zeros(len(sample.counts), dtype=bool)
    if not out.any():
        return Mistakes(aside)
    rest = state.of_rows(np.repeat(~out, axes))
    residuals = (state.readings - state.design @ rest.weights).reshape(-1, axes)
    quantities = {name: values[rows] for name, values in drivers(sample, robot).items()}
    common = in_common(residuals, out, sample.recordings.series[rows], quantities)
    aside[rows] = out & (not common)
    return Mistakes(aside, common, 0.0 if common else worth)


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
    if bdtrc(count - 1, rows, OPTIONS.remainder) < OPTIONS.level / _TESTS:
        return "they are too many"
    directions = residuals[chosen] / np.linalg.norm(residuals[chosen], axis=1, keepdims=True)
    width = directions.shape[1]
    resultant = float((directions.sum(axis=0) ** 2).sum()) * width / count
    if chdtrc(width, resultant) < OPTIONS.level / _TESTS:
        return "they point the same way"
    draws = _draws(rows, count)
    if np.mean(_pairs(series[draws]) >= _pairs(series[chosen])) < OPTIONS.level / _TESTS:
        return "they are of the same series"
    if drivers:
        scores = _rank_scores(drivers)
        observed = np.abs(scores[:, chosen].sum(axis=1))
        usual = np.abs(scores[:, draws].sum(axis=2)).max(axis=0)
        if np.mean(usual >= observed.max()) < OPTIONS.level / _TESTS:
            return f"they depend on {list(drivers)[int(np.argmax(observed)) % len(drivers)]}"
    return ""


@lru_cache(maxsize=16)
def _draws(rows: int, count: int) -> IntArray:
    """So many of the rows at random, again and again, shape (shuffles, count): the same for every model."""
    generator = np.random.default_rng(0)
    return np.array([generator.permutation(rows)[:count] for _ in range(_SHUFFLES)])


def _rank_scores(drivers: dict[str, FloatArray]) -> FloatArray:
    """Standardised ranks of every driver, and of its distance from its median, shape (2d, N)."""
    from scipy.stats import rankdata  # noqa: PLC0415 (slow to import, and few recordings need it)

    values = np.array(list(drivers.values()))
    distances = np.abs(values - np.median(values, axis=1, keepdims=True))
    ranks = rankdata(np.concatenate([values, distances]), axis=1)
    centred = ranks - ranks.mean(axis=1, keepdims=True)
    deviations = centred.std(axis=1, keepdims=True)
    scores: FloatArray = centred / np.where(deviations > 0.0, deviations, 1.0)
    return scores


def _pairs(series: IntArray) -> IntArray:
    """Number of pairs of rows that share a series, each twice and every row with itself; rows of (..., n) by draw."""
    found: IntArray = (series[..., :, None] == series[..., None, :]).sum(axis=(-2, -1))
    return found
