"""Choose m measurements out of candidates by O1 (D-optimality): optimal weights, rounding, exchange, and a bound.

With M(w) = Σ w_j·R_jᵀR_j and d_j = tr(R_j·M(w)⁻¹·R_jᵀ), the arithmetic mean of eigenvalues exceeds the geometric one,
so that det(M')^(1/p) ≤ det(M(w))^(1/p)·max_j d_j/p for the mean information M' of any plan (Kiefer & Wolfowitz 1960).
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.planning.optimality.exchange import rounded

_ITERATIONS, _PRUNE_EVERY, _DRAWS, _STARTS, _SWEEPS = 2000, 20, 200, 3, 50
_AT_ONCE = 64


@dataclass(frozen=True)
class DOptimalPlan:
    """A plan: indices of candidates (m,), its det(ΣM_i/m)^(1/p), and what no plan can exceed."""

    chosen: IntArray
    value: float
    bound: float


def choose_d_optimal(rows: FloatArray, count: int, generator: np.random.Generator) -> DOptimalPlan:
    """The best plan of `count` measurements, repetitions allowed, of candidates with whitened maps R (j, k, p).

    The square root of value and bound is O1 of a plan (theory.md 7) and the largest that O1 can be.
    """
    weights, bound = _weights(rows)
    plans = np.unique(np.sort(rounded(weights, count, _DRAWS, generator), axis=1), axis=0)
    values = _log_determinants(rows, plans)
    best: tuple[float, IntArray] | None = None
    for plan in plans[np.argsort(-values, kind="stable")[:_STARTS]]:
        improved, value = _exchanged(rows, plan.copy())
        if best is None or value > best[0]:
            best = (value, improved)
    assert best is not None
    parameters = rows.shape[-1]
    return DOptimalPlan(best[1], float(np.exp(best[0] / parameters) / count), bound)


def _weights(rows: FloatArray, tolerance: float = 1e-3) -> tuple[FloatArray, float]:
    """Weights by the multiplicative algorithm, and the bound that they prove."""
    parameters = rows.shape[-1]
    alive = np.arange(len(rows))
    weights = np.full(len(rows), 1.0 / len(rows))
    bound = np.inf
    for iteration in range(_ITERATIONS):
        weighted = (np.sqrt(weights[alive])[:, None, None] * rows[alive]).reshape(-1, parameters)
        information = weighted.T @ weighted
        whole = iteration % _PRUNE_EVERY == 0
        sensitivities = _sensitivities(rows if whole else rows[alive], information)
        if whole:
            root = float(np.exp(np.linalg.slogdet(information)[1] / parameters))
            bound = min(bound, root * float(sensitivities.max()) / parameters)
            if bound <= root * (1.0 + tolerance):
                break
            # Candidates without weight come back where they matter; the others need no work.
            back = sensitivities > parameters * (1.0 + 0.1 * tolerance)
            weights = np.where(back & (weights < 1e-8), 1e-4, weights)
            alive = np.flatnonzero((weights > 1e-8) | back)
            sensitivities = sensitivities[alive]
        weights[alive] *= (sensitivities / parameters) ** 1.7
        weights[weights < 1e-9] = 0.0
        weights /= weights.sum()
    return weights, bound


def _sensitivities(rows: FloatArray, information: FloatArray) -> FloatArray:
    values: FloatArray = (_turned(rows, information) ** 2).sum(axis=(1, 2))
    return values


def _turned(rows: FloatArray, information: FloatArray) -> FloatArray:
    """R·Z with Z·Zᵀ = M⁻¹, shape (j, k, p), as one product of matrices for all candidates."""
    root = np.linalg.inv(np.linalg.cholesky(information))
    return (rows.reshape(-1, rows.shape[-1]) @ root.T).reshape(rows.shape)


def _log_determinants(rows: FloatArray, plans: IntArray) -> FloatArray:
    stacked = rows[plans].reshape(len(plans), -1, rows.shape[-1])
    values: FloatArray = np.linalg.slogdet(stacked.swapaxes(1, 2) @ stacked)[1]
    return values


def _exchanged(rows: FloatArray, plan: IntArray) -> tuple[IntArray, float]:
    """A plan after exchanges that raise the determinant: det(M + RᵀR) = det(M)·det(I + R·M⁻¹·Rᵀ)."""
    value = float(_log_determinants(rows, plan[None])[0])
    for _ in range(_SWEEPS):
        before = value
        for place in range(len(plan)):
            without = rows[np.delete(plan, place)].reshape(-1, rows.shape[-1])
            matrix = without.T @ without
            sign, rest = np.linalg.slogdet(matrix)
            if sign > 0.0 and np.linalg.cond(matrix) < 1e12:
                winner, gain = _largest_gain(_turned(rows, matrix))
                found = rest + gain
            else:
                values = np.linalg.slogdet(matrix + rows.swapaxes(1, 2) @ rows)[1]
                winner = int(np.argmax(values))
                found = float(values[winner])
            if found > value + 1e-10:
                plan[place], value = winner, found
        if value <= before + 1e-9:
            break
    return plan, value


def _largest_gain(turned: FloatArray) -> tuple[int, float]:
    """The candidate with the largest log det(I + R·M⁻¹·Rᵀ), and that; `turned` is R·M^(−1/2) (j, k, p).

    By the inequality of the means none is larger than k·log(1 + tr/k), so that few determinants have to be computed.
    """
    count = turned.shape[1]
    above = count * np.log1p((turned**2).sum(axis=(1, 2)) / count)
    order = np.argsort(-above, kind="stable")
    best, winner = -np.inf, int(order[0])
    for start in range(0, len(order), _AT_ONCE):
        some = order[start : start + _AT_ONCE]
        if above[some[0]] <= best:
            break
        gains = np.linalg.slogdet(np.eye(count) + turned[some] @ turned[some].swapaxes(1, 2))[1]
        place = int(np.argmax(gains))
        if gains[place] > best:
            best, winner = float(gains[place]), int(some[place])
    return winner, best
