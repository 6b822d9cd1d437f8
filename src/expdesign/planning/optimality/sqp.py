"""Minimise the largest of several smooth functions for many designs at once: sequential quadratic programming.

Every design b has its own minimax problem  min max_j φ_bj(x)  within bounds and the robot's limits. The method is a
trust-region SQP with an exact ℓ1 penalty for the limits and damped BFGS matrices (Nocedal & Wright 2006, algorithms
18.4 and 18.6); the quadratic programs of all designs are solved together (`quadratic.py`), so that a step for a hundred
designs costs little more than the hundred gradients in it.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.mechanics.robots.robot import CONDITION_LIMIT
from expdesign.planning.optimality.quadratic import Programs, solve
from expdesign.planning.problem import DesignProblem

MARGIN = 1e-8
"""By which rows of limits are kept below zero, so that a design at a limit is within it whatever the rounding."""
_DIFFERENCE = 1e-6
"""Step of central differences of limits (m or rad)."""
_PENALTY, _INVALID = 10.0, 1e6
"""On the excess over limits, beside functions of the order of 1, and the value of a function where it has none."""
_CORRECTIONS = 2
"""Of a step that goes beyond curved limits (Maratos effect)."""
_ENTRIES = 20_000_000
"""Of the Hessians that are treated at once, at most."""


class Limits:
    """Rows c ≤ 0 of single measurements: the limited coordinates, in parts of their range, and the condition, in
    decades.
    """

    def __init__(self, problem: DesignProblem) -> None:
        self._problem = problem
        self._robot = problem.loaded.robot
        space = problem.space
        columns = np.array([variable.columns[0] for variable in space.variables], dtype=np.int64)
        self._decisions = np.flatnonzero(~space.discrete & (columns < space.n_pose))
        self._coordinates = columns[self._decisions]
        low, high = self._robot.limits
        stroke = np.where(np.isfinite(high - low) & (high > low), high - low, 1.0)  # a locked joint has none
        self._finite = np.flatnonzero(np.isfinite(np.concatenate([high, low])))
        signs = np.concatenate([np.ones(len(high)), -np.ones(len(low))])
        self._signed = (signs / np.tile(stroke, 2))[self._finite]
        self._ends = np.concatenate([high, low])[self._finite]

    def rows(self, variables: FloatArray, *, condition_row: bool = True) -> tuple[FloatArray, FloatArray]:
        """Values c (..., r) and their gradients (..., r, g) at measurements with variables (..., g).

        Without `condition_row` that of the condition, the last one, is left at −1, as far from a singularity.
        """
        poses = self._problem.space.decode(variables)[0]
        values, by_pose = np.zeros((*poses.shape[:-1], 0)), np.zeros((*poses.shape[:-1], 0, poses.shape[-1]))
        if self._finite.size:
            values, by_pose = self._reach(poses), _central(self._reach, poses).swapaxes(-1, -2)
        if condition_row:
            condition, by_condition = self._condition(poses)
        else:
            condition, by_condition = np.full(poses.shape[:-1], -1.0), np.zeros_like(poses)
        values = np.concatenate([values, condition[..., None]], axis=-1) + MARGIN
        by_pose = np.concatenate([by_pose, by_condition[..., None, :]], axis=-2)
        gradient = np.zeros((*values.shape, variables.shape[-1]))
        gradient[..., self._decisions] = by_pose[..., self._coordinates]
        return values, gradient

    def _reach(self, poses: FloatArray) -> FloatArray:
        at = self._robot.limited(poses)
        found: FloatArray = (np.concatenate([at, at], axis=-1)[..., self._finite] - self._ends) * self._signed
        return found

    def _condition(self, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
        """log10 of the scaled condition number over its limit; its gradient is needed only near the limit."""

        def decades(at: FloatArray) -> FloatArray:
            condition = self._robot.jacobians(at).condition
            values: FloatArray = np.log10(np.minimum(condition, 1e300) / CONDITION_LIMIT)
            return values

        values = decades(poses)
        gradient = np.zeros_like(poses)
        near = values > np.log10(0.3)
        if near.any():
            gradient[near] = _central(decades, poses[near])
        return values, gradient


def _central(function: Callable[[FloatArray], FloatArray], poses: FloatArray) -> FloatArray:
    """Central differences of a function of poses (..., n) with values (..., ·), shape (..., n, ·)."""
    steps = _DIFFERENCE * np.eye(poses.shape[-1])
    difference = function(poses[..., None, :] + steps) - function(poses[..., None, :] - steps)
    return difference / (2.0 * _DIFFERENCE)


Pieces = Callable[[FloatArray, IntArray], tuple[FloatArray, FloatArray]]
"""Functions to be made small: (variables (b, m, g), which problems they belong to (b,)) → values (b, j) and gradients
(b, j, m, g)."""
Tie = Callable[[FloatArray, IntArray], FloatArray]
"""Projection of changes of variables (b, m, g) of the given problems (b,) onto those that keep shared poses shared."""


@dataclass
class _Points:
    """Where some designs stand: variables, functions and limits, with derivatives per part of a free variable's range.

    Attributes:
        variables: shape (b, m, g).
        values: φ, shape (b, j).
        gradients: shape (b, j, m·f) for f free variables.
        limits: shape (b, m, r).
        limit_gradients: shape (b, m, r, f).
    """

    variables: FloatArray
    values: FloatArray
    gradients: FloatArray
    limits: FloatArray
    limit_gradients: FloatArray

    def take(self, index: IntArray) -> "_Points":
        return _Points(*(getattr(self, field.name)[index] for field in fields(self)))

    def put(self, index: IntArray, other: "_Points") -> None:
        for field in fields(self):
            getattr(self, field.name)[index] = getattr(other, field.name)

    @property
    def merit(self) -> FloatArray:
        """The largest φ and the penalty, shape (b,)."""
        return _merit(self.values, self.limits)


class MinimaxSearch:
    """The minimax problems of some designs.

    Args:
        problem: gives bounds, limits and which variables are continuous.
        pieces: the functions.
        tie: keeps shared poses shared; None where nothing is shared.
    """

    def __init__(self, problem: DesignProblem, pieces: Pieces, tie: Tie | None = None) -> None:
        self._space = problem.space
        self._pieces, self._tie = pieces, tie
        self._limits = Limits(problem)
        self._inner, self._interrupt = 1e-9, problem.interrupt
        self._free: BoolArray = (~self._space.discrete) & (self._space.upper > self._space.lower)
        self._span = (self._space.upper - self._space.lower)[self._free]

    def minimise(
        self,
        variables: FloatArray,
        *,
        iterations: int = 60,
        radius: float = 0.2,
        tolerance: float = 1e-9,
        inner: float = 1e-9,
    ) -> FloatArray:
        """Improved variables (b, m, g); discrete variables stay as they are.

        Args:
            variables: starts within the bounds, shape (b, m, g).
            iterations: largest number of steps.
            radius: first trust radius, in parts of a variable's range.
            tolerance: a design is finished when its largest function cannot be expected to fall by this part of its
                size (at least of 1) in two steps running.
            inner: relative duality gap to which the quadratic programs are solved.
        """
        self._inner = inner
        if not self._free.any() or len(variables) == 0:
            return variables.copy()
        together = max(1, _ENTRIES // (variables.shape[1] * len(self._span)) ** 2)
        parts = np.split(np.arange(len(variables)), np.arange(together, len(variables), together))
        return np.concatenate([self._minimise(variables[part], part, iterations, radius, tolerance) for part in parts])

    def _minimise(
        self, variables: FloatArray, index: IntArray, iterations: int, radius: float, tolerance: float
    ) -> FloatArray:
        n = variables.shape[1] * len(self._span)
        hessian = np.tile(np.eye(n), (len(variables), 1, 1))
        fresh = np.ones(len(variables), dtype=bool)
        radii, quiet = np.full(len(variables), radius), np.zeros(len(variables), dtype=np.int64)
        alive = np.arange(len(variables))
        points = self._evaluate(variables, index)
        for _ in range(iterations):
            if alive.size == 0:
                break
            self._interrupt()
            here = points.take(alive)
            solution, *multipliers = self._solved(here, hessian[alive], radii[alive])
            moved = self._moved(here, solution, index[alive])
            step = ((moved - here.variables)[..., self._free] / self._span).reshape(len(alive), n)
            predicted = here.merit - _model(here, hessian[alive], step)
            trial = self._evaluate(moved, index[alive])
            actual = here.merit - trial.merit
            ratio = np.where(predicted > 0.0, actual / np.where(predicted > 0.0, predicted, 1.0), -1.0)
            accepted = (ratio > 1e-3) & (actual > 0.0)
            hessian[alive], fresh[alive] = _updated(hessian[alive], fresh[alive], here, trial, step, *multipliers)
            size = np.abs(step).max(axis=1)
            grown = (ratio > 0.75) & (size > 0.8 * radii[alive])
            shrunk = np.where(ratio < 0.25, 0.35 * np.maximum(size, 1e-12), radii[alive])
            radii[alive] = np.minimum(1.0, np.where(grown, 2.0 * radii[alive], shrunk))
            points.put(alive[accepted], trial.take(np.flatnonzero(accepted)))
            small = predicted < tolerance * np.maximum(1.0, np.abs(here.merit))
            quiet[alive] = np.where(small, quiet[alive] + 1, 0)
            alive = alive[(quiet[alive] < 2) & (radii[alive] > 1e-9)]
        # Steps that came to their number may be a little beyond curved limits.
        beyond = np.flatnonzero((points.limits > 0.0).any(axis=(1, 2)))
        for _ in range(_CORRECTIONS if beyond.size else 0):
            there = points.take(beyond)
            points.variables[beyond] = self._moved(there, np.zeros((len(beyond), n)), index[beyond])
        return points.variables

    def _moved(self, here: _Points, step: FloatArray, index: IntArray) -> FloatArray:
        """Variables after a step in parts of the free variables' ranges, within the bounds."""
        variables = here.variables
        singular = bool((here.limits[..., -1] > -0.7).any())
        change = np.zeros_like(variables)
        change[..., self._free] = step.reshape(*variables.shape[:2], -1) * self._span
        if self._tie is not None:
            change = self._tie(change, index)
        moved: FloatArray = np.clip(variables + change, self._space.lower, self._space.upper)
        beyond = np.arange(len(moved))
        for _ in range(_CORRECTIONS):
            # Limits are curved: without this correction full steps along them would be refused (Maratos effect).
            shift = self._back_within_limits(moved[beyond], singular)
            if self._tie is not None:
                shift = self._tie(shift, index[beyond])
            moved[beyond] = np.clip(moved[beyond] + shift, self._space.lower, self._space.upper)
            beyond = beyond[(shift != 0.0).any(axis=(1, 2))]
            if beyond.size == 0:
                break
        return moved

    def _back_within_limits(self, variables: FloatArray, singular: bool) -> FloatArray:
        """Shortest changes (b, m, g) that take violated limits, linearised, to zero."""
        shift = np.zeros_like(variables)
        values, gradients = self._limits.rows(variables, condition_row=singular)
        beyond = (values > 0.0).any(axis=-1)
        if beyond.any():
            excess = np.maximum(values[beyond], 0.0)
            rows = gradients[beyond][..., self._free] * self._span * (excess > 0.0)[..., None]
            gram = rows @ rows.swapaxes(-1, -2)
            size = np.maximum(np.trace(gram, axis1=-2, axis2=-1), 1e-300)[:, None, None]
            gram = gram + size * (
                np.eye(values.shape[-1]) * (excess == 0.0)[:, None] + 1e-12 * np.eye(values.shape[-1])
            )
            with np.errstate(all="ignore"):
                back = -(rows.swapaxes(-1, -2) @ np.linalg.solve(gram, excess[..., None]))[..., 0] * self._span
            # At a singular pose a limit has no gradient to go back along.
            back = np.where(np.isfinite(back), back, 0.0)
            part = np.zeros((len(back), variables.shape[-1]))
            part[:, self._free] = back
            shift[beyond] = part
        return shift

    def _evaluate(self, variables: FloatArray, index: IntArray) -> _Points:
        values, slopes = self._pieces(variables, index)
        if self._tie is not None:
            parts = [self._tie(slopes[:, piece], index) for piece in range(slopes.shape[1])]
            slopes = np.stack(parts, axis=1)
        slopes = np.nan_to_num(slopes[..., self._free] * self._span)
        values = np.where(np.isfinite(values).all(axis=1, keepdims=True), values, _INVALID)
        limits, limit_gradients = self._limits.rows(variables)
        limit_gradients = limit_gradients[..., self._free] * self._span
        return _Points(variables.copy(), values, slopes.reshape(*slopes.shape[:2], -1), limits, limit_gradients)

    def _solved(
        self, here: _Points, hessian: FloatArray, radii: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Steps (b, n) that are best for the quadratic models within the bounds and the trust regions, and multipliers
        of the pieces (b, j) and the limits (b, m, r).

        Programs are solved in units of the trust radius and of the change of φ over it, with those limits alone that
        some step can violate.
        """
        (batch, pieces, n), (_, m, each, free), radius = (
            here.gradients.shape,
            here.limit_gradients.shape,
            radii[:, None],
        )
        unit = np.maximum(np.abs(here.gradients).reshape(batch, -1).max(axis=1) * radii, 1e-12)[:, None]
        sides = (
            ((side - here.variables)[..., self._free] / self._span).reshape(batch, n)
            for side in (self._space.lower, self._space.upper)
        )
        low, high = (np.clip(side, -radius, radius) for side in sides)
        low, high = np.minimum(low, -1e-14) / radius, np.maximum(high, 1e-14) / radius
        limits = np.maximum(here.limits / radius[..., None], -1e3).reshape(batch, -1)
        far = np.maximum(high, -low).reshape(batch, m, 1, free)
        reached = limits + (np.abs(here.limit_gradients) * far).sum(axis=3).reshape(batch, -1) > 0.0
        number = int(reached.sum(axis=1).max(initial=0))
        chosen = np.argsort(~reached, axis=1, kind="stable")[:, :number]
        blocks = here.limit_gradients.reshape(batch, m * each, free)
        rows = np.zeros((batch, number, m, free))
        rows[np.arange(batch)[:, None], np.arange(number), chosen // each] = np.take_along_axis(
            blocks, chosen[..., None], axis=1
        )
        values = np.maximum((here.values - here.values.max(axis=1, keepdims=True)) / unit, -1e3)
        level = np.broadcast_to(np.arange(pieces + number) < pieces, (batch, pieces + number)).astype(float)
        programs = Programs(
            hessian=hessian * (radius**2 / unit)[..., None],
            values=np.concatenate([values, np.take_along_axis(limits, chosen, axis=1)], axis=1),
            rows=np.concatenate([here.gradients * (radius / unit)[..., None], rows.reshape(batch, number, n)], axis=1),
            level=level,
            penalty=np.where(level > 0.0, 2.0, _PENALTY * radius / unit),
            low=low,
            high=high,
        )
        step, found = solve(programs, self._inner)
        multipliers = np.zeros((batch, m * each))
        np.put_along_axis(multipliers, chosen, found[:, pieces:] * unit / radius, axis=1)
        return step * radius, found[:, :pieces], multipliers.reshape(batch, m, each)


def _merit(values: FloatArray, limits: FloatArray) -> FloatArray:
    merit: FloatArray = values.max(axis=1) + _PENALTY * np.maximum(limits, 0.0).sum(axis=(1, 2))
    return merit


def _model(here: _Points, hessian: FloatArray, step: FloatArray) -> FloatArray:
    """The quadratic model of the merit at steps (b, n)."""
    values = here.values + (here.gradients @ step[..., None])[..., 0]
    by_measurement = step.reshape(*here.limits.shape[:2], -1, 1)
    limits = here.limits + (here.limit_gradients @ by_measurement)[..., 0]
    curvature = 0.5 * (step[:, None] @ hessian @ step[..., None])[:, 0, 0]
    return _merit(values, limits) + curvature


def _updated(
    hessian: FloatArray,
    fresh: BoolArray,
    here: _Points,
    trial: _Points,
    step: FloatArray,
    pieces: FloatArray,
    limits: FloatArray,
) -> tuple[FloatArray, BoolArray]:
    """Damped BFGS updates with the Lagrangians' gradients at both ends of steps (b, n), by the multipliers of pieces
    and limits, and which are unused yet.
    """
    change = (pieces[:, None] @ (trial.gradients - here.gradients))[:, 0]
    by_limits = limits[:, :, None] @ (trial.limit_gradients - here.limit_gradients)
    change = change + by_limits.reshape(change.shape)
    length, curvature = (step * step).sum(axis=1), (step * change).sum(axis=1)
    valid = (length > 1e-24) & (trial.values.max(axis=1) < _INVALID) & np.isfinite(curvature)
    length = np.where(valid, length, 1.0)
    size = np.clip(np.linalg.norm(change, axis=1) / np.sqrt(length), 1e-3, 1e3)
    start = 0.1 * np.eye(step.shape[1]) * size[:, None, None]
    hessian = np.where((valid & fresh)[:, None, None], start, hessian)
    along = (hessian @ step[..., None])[..., 0]
    model = (step * along).sum(axis=1)
    valid &= model > 1e-200
    model = np.where(valid, model, 1.0)
    mixing = np.where(curvature >= 0.2 * model, 1.0, 0.8 * model / np.where(valid, model - curvature, 1.0))[:, None]
    damped = mixing * change + (1.0 - mixing) * along
    inner = np.where(valid, (step * damped).sum(axis=1), 1.0)
    scaled = damped / np.sqrt(np.maximum(inner, 1e-200))[:, None]
    removed = along / np.sqrt(model)[:, None]
    updated = hessian + scaled[:, :, None] * scaled[:, None] - removed[:, :, None] * removed[:, None]
    valid &= np.isfinite(updated).all(axis=(1, 2))
    return np.where(valid[:, None, None], updated, hessian), fresh & ~valid
