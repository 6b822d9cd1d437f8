"""Many small convex quadratic programs at once, by a primal-dual interior-point method.

Each is  min t + ½·dᵀHd + ν·Σs  subject to  φ + J·d ≤ t,  c_i + N_i·d_i ≤ s_i,  s ≥ 0,  low ≤ d ≤ high,  where the
limit rows N_i concern the variables d_i of measurement i alone, which keeps the cost of a row independent of how many
measurements there are (Nocedal & Wright 2006, chapters 16 and 18.5, for the method and the exact penalty). The numbers
should be scaled so that steps, and changes of φ, are of the order of 1.
"""

from dataclasses import dataclass, fields, replace

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray

_ITERATIONS = 40


@dataclass(frozen=True)
class Programs:
    """b programs in n = m·g variables.

    Attributes:
        hessian: H, positive definite, shape (b, n, n).
        values: φ, shape (b, j).
        gradients: J, shape (b, j, n).
        limits: c, shape (b, m, r).
        limit_gradients: N, shape (b, m, r, g).
        low: shape (b, n), below `high` everywhere.
        high: shape (b, n).
        penalty: ν, shape (b,).
    """

    hessian: FloatArray
    values: FloatArray
    gradients: FloatArray
    limits: FloatArray
    limit_gradients: FloatArray
    low: FloatArray
    high: FloatArray
    penalty: FloatArray

    def with_limits(self, rows: IntArray) -> "Programs":
        """The same with some of the limit rows (b, m, r') of every measurement."""
        limits = np.take_along_axis(self.limits, rows, axis=2)
        return replace(
            self, limits=limits, limit_gradients=np.take_along_axis(self.limit_gradients, rows[..., None], axis=2)
        )


@dataclass(frozen=True)
class Solutions:
    """Minimisers d (b, n), multipliers of the pieces (b, j), which add up to 1, and of the limits (b, m, r)."""

    step: FloatArray
    pieces: FloatArray
    limits: FloatArray

    def put(self, index: IntArray, iterate: "_Iterate") -> None:
        """Write where the programs with these indices stand."""
        self.step[index], self.pieces[index], self.limits[index] = iterate.d, iterate.lam, iterate.mu


def _reachable(q: Programs) -> IntArray:
    """Limit rows (b, m, r'), as many for every measurement, with all those that any d within the bounds violates."""
    far = np.maximum(q.high, -q.low).reshape(len(q.low), q.limits.shape[1], 1, -1)
    reachable = q.limits + (np.abs(q.limit_gradients) * far).sum(axis=3) > 0.0
    number = int(reachable.sum(axis=2).max(initial=0))
    return np.sort(np.argsort(~reachable, axis=2, kind="stable")[..., :number], axis=2)


def solve(programs: Programs, tolerance: float = 1e-9) -> Solutions:
    """Solve all programs to a relative duality gap (fewer digits where rounding does not permit more)."""
    rows = _reachable(programs)
    if rows.shape[2] < programs.limits.shape[2]:
        found = solve(programs.with_limits(rows), tolerance)
        limits = np.zeros(programs.limits.shape)
        np.put_along_axis(limits, rows, found.limits, axis=2)
        return Solutions(found.step, found.pieces, limits)
    iterate = _Iterate(programs)
    solutions = Solutions(iterate.d.copy(), iterate.lam.copy(), iterate.mu.copy())
    left = np.arange(len(iterate.d))
    for step in range(_ITERATIONS + 1):
        gap, residuals = iterate.residuals()
        unfinished = np.maximum(gap, residuals.worst) > tolerance
        # What is finished costs nothing any more once it is a good part of all.
        if unfinished.mean() < 0.8 or step == _ITERATIONS:
            solutions.put(left, iterate)
            keep = np.flatnonzero(unfinished)
            if keep.size == 0 or step == _ITERATIONS:
                break
            left, gap, residuals, unfinished = left[keep], gap[keep], residuals.take(keep), unfinished[keep]
            iterate.take(keep)
        # Where the last step could be taken in full the next one may aim far; else it centres first.
        aim = np.where(iterate.last > 0.9, 0.01, np.where(iterate.last > 0.5, 0.1, 0.3))
        iterate.advance(aim * gap, residuals, unfinished)
    return solutions


@dataclass(frozen=True)
class _Residuals:
    """What the optimality conditions lack: stationarity in d and t, and the two kinds of rows."""

    by_d: FloatArray
    by_t: FloatArray
    pieces: FloatArray
    limits: FloatArray

    def take(self, index: IntArray) -> "_Residuals":
        return _Residuals(*(getattr(self, field.name)[index] for field in fields(self)))

    @property
    def worst(self) -> FloatArray:
        parts = (self.by_d, self.by_t[:, None], self.pieces, self.limits)
        return np.max([np.abs(part).reshape(len(part), -1).max(axis=1, initial=0.0) for part in parts], axis=0)


class _Iterate:
    """Primal and dual variables of all programs; slacks are variables of their own, so that none is a difference."""

    def __init__(self, q: Programs) -> None:
        self.q = q
        batch, self.n = q.low.shape
        self.shape = q.limit_gradients.shape
        width = q.high - q.low
        self.d = np.clip(0.0, q.low + 0.1 * width, q.high - 0.1 * width)
        pieces = q.values + (q.gradients @ self.d[..., None])[..., 0]
        self.t = pieces.max(axis=1) + 0.3
        self.above, self.below = self.d - q.low, q.high - self.d
        self.above_dual = 0.1 / np.maximum(self.above, 0.01)
        self.below_dual = 0.1 / np.maximum(self.below, 0.01)
        self.slack = self.t[:, None] - pieces
        closeness = 1.0 / self.slack
        self.lam = closeness / closeness.sum(axis=1, keepdims=True)
        self.last = np.full(batch, 0.6)
        by_measurement = self.d.reshape(batch, self.shape[1], self.shape[3], 1)
        limits = q.limits + (q.limit_gradients @ by_measurement)[..., 0]
        self.soft = 0.1 + np.maximum(limits, 0.0)
        self.room = self.soft - limits
        # Multipliers on the central path for a product of 0.1, as far as their bounds permit.
        self.mu = np.minimum(0.1 / self.room, 0.5 * q.penalty[:, None, None])
        self.rest = q.penalty[:, None, None] - self.mu

    def take(self, index: IntArray) -> None:
        """Go on with the programs with these indices only."""
        self.q = Programs(*(getattr(self.q, field.name)[index] for field in fields(self.q)))
        self.shape = self.q.limit_gradients.shape
        for name, value in vars(self).items():
            if isinstance(value, np.ndarray):
                setattr(self, name, value[index])

    def residuals(self) -> tuple[FloatArray, _Residuals]:
        """Mean complementarity product (b,) and residuals."""
        q, (batch, m, _, g) = self.q, self.shape
        products = (
            (self.above * self.above_dual).sum(axis=1)
            + (self.below * self.below_dual).sum(axis=1)
            + (self.slack * self.lam).sum(axis=1)
            + (self.room * self.mu + self.soft * self.rest).sum(axis=(1, 2))
        )
        gap = products / (2 * self.n + self.lam.shape[1] + 2 * self.mu[0].size)
        by_d = (
            (q.hessian @ self.d[..., None])[..., 0]
            + (self.lam[:, None] @ q.gradients)[:, 0]
            + (self.mu[:, :, None] @ q.limit_gradients).reshape(batch, self.n)
            - self.above_dual
            + self.below_dual
        )
        pieces = (q.gradients @ self.d[..., None])[..., 0] - self.t[:, None] + self.slack + q.values
        along = (q.limit_gradients @ self.d.reshape(batch, m, g, 1))[..., 0]
        return gap, _Residuals(by_d, 1.0 - self.lam.sum(axis=1), pieces, along + self.room - self.soft + q.limits)

    def advance(self, target: FloatArray, residuals: _Residuals, moving: BoolArray) -> None:
        """One Newton step towards complementarity products equal to `target` (b,), for the programs that move."""
        q, n, (batch, m, rows, g) = self.q, self.n, self.shape
        aim, around = target[:, None], target[:, None, None]
        weight = self.lam / self.slack
        wide = self.room / self.mu + self.soft / self.rest
        from_piece = aim / self.slack - self.lam + weight * residuals.pieces
        from_limit = residuals.limits + (around / self.mu - self.room) - (around / self.rest - self.soft)
        weighted = weight[..., None] * q.gradients
        matrix = np.empty((batch, n + 1, n + 1))
        np.matmul(q.gradients.swapaxes(1, 2), weighted, out=matrix[:, :n, :n])
        matrix[:, :n, :n] += q.hessian
        if rows:
            blocks = (q.limit_gradients / wide[..., None]).swapaxes(2, 3) @ q.limit_gradients
            for i in range(m):
                matrix[:, i * g : (i + 1) * g, i * g : (i + 1) * g] += blocks[:, i]
        index = np.arange(n)
        matrix[:, index, index] += self.above_dual / self.above + self.below_dual / self.below
        matrix[:, :n, n] = matrix[:, n, :n] = -weighted.sum(axis=1)
        matrix[:, n, n] = weight.sum(axis=1)
        right = np.empty((batch, n + 1))
        right[:, :n] = (
            -residuals.by_d
            - (from_piece[:, None] @ q.gradients)[:, 0]
            - ((from_limit / wide)[:, :, None] @ q.limit_gradients).reshape(batch, n)
            + (aim / self.above - self.above_dual)
            - (aim / self.below - self.below_dual)
        )
        right[:, n] = from_piece.sum(axis=1) - residuals.by_t
        solution = _solve_linear(matrix, right)
        d, t = solution[:, :n], solution[:, n]
        rise = (q.gradients @ d[..., None])[..., 0] - t[:, None]
        along = (q.limit_gradients @ d.reshape(batch, m, g, 1))[..., 0]
        mu = (along + from_limit) / wide
        primal = {
            "above": d,
            "below": -d,
            "slack": -residuals.pieces - rise,
            "room": around / self.mu - self.room - self.room / self.mu * mu,
            "soft": around / self.rest - self.soft + self.soft / self.rest * mu,
        }
        dual = {
            "above_dual": aim / self.above - self.above_dual - self.above_dual / self.above * d,
            "below_dual": aim / self.below - self.below_dual + self.below_dual / self.below * d,
            "lam": from_piece + weight * rise,
            "mu": mu,
            "rest": -mu,
        }
        length = np.where(moving, _longest([(getattr(self, key), step) for key, step in (primal | dual).items()]), 0.0)
        for key, step in (primal | dual).items():
            value = getattr(self, key)
            value += length.reshape(-1, *[1] * (value.ndim - 1)) * step
        self.last = length
        self.d += length[:, None] * d
        self.t += length * t


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


def _longest(pairs: list[tuple[FloatArray, FloatArray]]) -> FloatArray:
    """Longest step ≤ 1 (b,) that keeps every value positive, values and steps of shape (b, ...)."""
    steepest = np.zeros(len(pairs[0][0]))
    for value, step in pairs:
        steepest = np.maximum(steepest, (-step / value).reshape(len(value), -1).max(axis=1, initial=0.0))
    result: FloatArray = np.minimum(1.0, 0.995 / np.maximum(steepest, 1e-300))
    return result
