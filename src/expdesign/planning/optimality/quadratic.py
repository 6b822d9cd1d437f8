"""Many small convex quadratic programs at once, by a primal-dual interior-point method.

Each is  min t + ½·dᵀHd + Σν_r·s_r  subject to  c + A·d − e·t ≤ s,  s ≥ 0,  low ≤ d ≤ high, with e = 1 in the rows of
the functions whose largest is t, and 0 in those of limits (Nocedal & Wright 2006, chapters 16 and 18.5, for the method
and the exact penalty). The multipliers of the functions add up to 1, so that with ν > 1 none of them lies above t. The
numbers should be scaled so that steps, and changes of the functions, are of the order of 1.
"""

from dataclasses import dataclass, fields

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray

_ITERATIONS = 40


@dataclass(frozen=True)
class Programs:
    """b programs in n variables.

    Attributes:
        hessian: H, positive definite, shape (b, n, n).
        values: c, shape (b, r).
        rows: A, shape (b, r, n).
        level: e, shape (b, r).
        penalty: ν, shape (b, r).
        low: shape (b, n), below `high` everywhere.
        high: shape (b, n).
    """

    hessian: FloatArray
    values: FloatArray
    rows: FloatArray
    level: FloatArray
    penalty: FloatArray
    low: FloatArray
    high: FloatArray

    def take(self, index: IntArray) -> "Programs":
        """Those with these indices."""
        return Programs(*(getattr(self, field.name)[index] for field in fields(self)))


def solve(programs: Programs, tolerance: float = 1e-9) -> tuple[FloatArray, FloatArray]:
    """Minimisers d (b, n) and multipliers of the rows (b, r), to a relative duality gap, with fewer digits where
    rounding does not permit more.
    """
    iterate = _Iterate(programs)
    steps, multipliers = iterate.d.copy(), iterate.mu.copy()
    left = np.arange(len(steps))
    for step in range(_ITERATIONS + 1):
        gap, residuals = iterate.residuals()
        worst = np.max([np.abs(part).max(axis=1, initial=0.0) for part in residuals], axis=0)
        unfinished = np.maximum(gap, worst) > tolerance
        # What is finished costs nothing any more once it is a good part of all.
        if unfinished.mean() < 0.8 or step == _ITERATIONS:
            steps[left], multipliers[left] = iterate.d, iterate.mu
            keep = np.flatnonzero(unfinished)
            if keep.size == 0 or step == _ITERATIONS:
                break
            left, gap, residuals, unfinished = left[keep], gap[keep], [r[keep] for r in residuals], unfinished[keep]
            iterate.take(keep)
        # Where the last step could be taken in full the next one may aim far; else it centres first.
        aim = np.where(iterate.last > 0.9, 0.01, np.where(iterate.last > 0.5, 0.1, 0.3))
        iterate.advance(aim * gap, residuals, unfinished)
    return steps, multipliers


class _Iterate:
    """Primal and dual variables of all programs; slacks are variables of their own, so that none is a difference."""

    def __init__(self, q: Programs) -> None:
        self.q = q
        width = q.high - q.low
        self.d = np.clip(0.0, q.low + 0.1 * width, q.high - 0.1 * width)
        rows = q.values + _times(q.rows, self.d)
        self.t = np.where(q.level > 0.0, rows, -np.inf).max(axis=1, keepdims=True) + 0.3
        self.above, self.below = self.d - q.low, q.high - self.d
        self.above_dual, self.below_dual = 0.1 / np.maximum(self.above, 0.01), 0.1 / np.maximum(self.below, 0.01)
        rows = rows - q.level * self.t
        self.soft = 0.1 + np.maximum(rows, 0.0)
        self.room = self.soft - rows
        # Multipliers on the central path for a product of 0.1, as far as their bounds permit.
        self.mu = np.minimum(0.1 / self.room, 0.5 * q.penalty)
        self.rest = q.penalty - self.mu
        self.last = np.full(len(self.d), 0.6)

    def take(self, index: IntArray) -> None:
        """Go on with the programs with these indices only."""
        self.q = self.q.take(index)
        for name, value in vars(self).items():
            if isinstance(value, np.ndarray):
                setattr(self, name, value[index])

    def residuals(self) -> tuple[FloatArray, list[FloatArray]]:
        """Mean complementarity product (b,), and what the optimality conditions lack: stationarity in d (b, n) and t
        (b, 1), and the rows (b, r).
        """
        q = self.q
        pairs = (
            (self.above, self.above_dual),
            (self.below, self.below_dual),
            (self.room, self.mu),
            (self.soft, self.rest),
        )
        gap = sum((value * dual).sum(axis=1) for value, dual in pairs) / sum(value.shape[1] for value, _ in pairs)
        by_d = _times(q.hessian, self.d) + _times(q.rows.swapaxes(1, 2), self.mu) - self.above_dual + self.below_dual
        by_t = 1.0 - (q.level * self.mu).sum(axis=1, keepdims=True)
        rows = q.values + _times(q.rows, self.d) - q.level * self.t + self.room - self.soft
        return gap, [by_d, by_t, rows]

    def advance(self, target: FloatArray, residuals: list[FloatArray], moving: BoolArray) -> None:
        """One Newton step towards complementarity products equal to `target` (b,), for the programs that move."""
        q, aim, (by_d, by_t, rows), n = self.q, target[:, None], residuals, self.d.shape[1]
        weight = 1.0 / (self.room / self.mu + self.soft / self.rest)
        lacking = rows + (aim / self.mu - self.room) - (aim / self.rest - self.soft)
        weighted, transposed = weight[..., None] * q.rows, q.rows.swapaxes(1, 2)
        matrix = np.empty((len(target), n + 1, n + 1))
        np.matmul(transposed, weighted, out=matrix[:, :n, :n])
        matrix[:, :n, :n] += q.hessian
        index = np.arange(n)
        matrix[:, index, index] += self.above_dual / self.above + self.below_dual / self.below
        matrix[:, :n, n] = matrix[:, n, :n] = -(q.level[:, None] @ weighted)[:, 0]
        matrix[:, n, n] = (q.level * weight).sum(axis=1)
        right = np.empty((len(target), n + 1))
        right[:, :n] = (
            (aim / self.above - self.above_dual)
            - (aim / self.below - self.below_dual)
            - by_d
            - _times(transposed, weight * lacking)
        )
        right[:, n] = (q.level * weight * lacking).sum(axis=1) - by_t[:, 0]
        solution = _solve_linear(matrix, right)
        d, t = solution[:, :n], solution[:, n:]
        mu = weight * (_times(q.rows, d) - q.level * t + lacking)
        changes = {
            "above": d,
            "below": -d,
            "room": (aim - self.room * mu) / self.mu - self.room,
            "soft": (aim + self.soft * mu) / self.rest - self.soft,
            "above_dual": (aim - self.above_dual * d) / self.above - self.above_dual,
            "below_dual": (aim + self.below_dual * d) / self.below - self.below_dual,
            "mu": mu,
            "rest": -mu,
        }
        steepest = [(-step / getattr(self, name)).max(axis=1, initial=0.0) for name, step in changes.items()]
        # The longest step up to 1 that keeps every value positive.
        length = np.minimum(1.0, 0.995 / np.maximum(np.max(steepest, axis=0), 1e-300)) * moving
        for name, step in (changes | {"d": d, "t": t}).items():
            value = getattr(self, name)
            value += length[:, None] * step
        self.last = length


def _times(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    """Products (b, r) of matrices (b, r, n) and vectors (b, n)."""
    product: FloatArray = (matrices @ vectors[..., None])[..., 0]
    return product


def _solve_linear(matrices: FloatArray, right: FloatArray) -> FloatArray:
    """Solutions (b, n) of linear systems, which are scaled to unit diagonals in place; of a singular one, with a small
    ridge.
    """
    diagonal = np.sqrt(np.abs(np.diagonal(matrices, axis1=1, axis2=2)))
    unit = 1.0 / np.where(diagonal > 0.0, diagonal, 1.0)
    matrices *= unit[:, :, None]
    matrices *= unit[:, None]
    scaled = (right * unit)[..., None]
    try:
        solution = np.linalg.solve(matrices, scaled)[..., 0]
    except np.linalg.LinAlgError:
        solution = np.linalg.solve(matrices + 1e-10 * np.eye(matrices.shape[1]), scaled)[..., 0]
    result: FloatArray = solution * unit
    return result
