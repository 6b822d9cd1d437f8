"""Maps over the workspace of the error to expect after calibration.

The error that a compensated robot is left with at a pose X is −A(X)·ε_c (theory.md 4.2), with ε_c the error of the
identified compliances. A target's load and tolerances are carried to other poses; there, Σ_i var_i/tol_i² is
tr(W(X)·C) with W = Σ_i a_iᵀ·a_i/tol_i² of the rows of A(X) and C the covariance of the compliances. W holds all of the
pose and C all of the plan, so that the map of any plan is a product away.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.mechanics.robots.robot import CONDITION_LIMIT, LIMIT_MARGIN
from expdesign.planning.criteria.targets import body_axes
from expdesign.planning.problem import DesignProblem

_IDLE = 1e-9
"""Share of the deflection below which an actuator carries nothing."""
POINTS = 17
"""Points along each side of a map."""


@dataclass(frozen=True)
class AccuracyMap:
    """One plane of configurations about a target.

    Attributes:
        target: index of the target; its other coordinates, its load and its tolerances hold on the whole map.
        axes: the two coordinates that vary, as indices of `robot.configuration`.
        across: values of the first, shape (u,).
        up: values of the second, shape (v,).
        weight: W (N²/m² …), shape (v, u, n_p, n_p); NaN where the robot cannot be, or is nearly singular.
    """

    target: int
    axes: tuple[int, int]
    across: FloatArray
    up: FloatArray
    weight: FloatArray

    def rms(self, covariance: FloatArray) -> FloatArray:
        """RMS error in tolerances, shape (..., v, u), from covariances of the compliances (..., n_p, n_p).

        NaN in the covariance marks compliances that are not determined; the error is known where they do not count.
        """
        unknown = np.isnan(covariance)
        squares = np.einsum("vupq,...pq->...vu", self.weight, np.where(unknown, 0.0, covariance))
        counts = np.einsum("vupq,...pq->...vu", (self.weight != 0.0).astype(float), unknown.astype(float)) > 0.0
        squares = np.where(counts, np.nan, squares)
        rms: FloatArray = np.sqrt(np.maximum(squares, 0.0))
        return rms


def accuracy_maps(problem: DesignProblem, points: int = POINTS) -> list[AccuracyMap]:
    """Maps about every target, in the first two planes of which the design space or the targets span something.

    For robots whose configuration is the pose these are x-y, x-z and y-z; for others, pairs of neighbouring joints.
    The range is that of the poses where measurements may be taken, widened to hold the targets.
    """
    low, high = _range(problem)
    spans = high - low
    wide = [pair for pair in _pairs(problem) if spans[pair[0]] > 0.0 and spans[pair[1]] > 0.0]
    maps = []
    for target, pose in enumerate(problem.targets.configurations):
        for first, second in wide[:2]:
            across, up = (np.linspace(low[axis], high[axis], points) for axis in (first, second))
            grid = np.broadcast_to(pose, (points, points, len(pose))).copy()
            grid[..., first], grid[..., second] = across[None, :], up[:, None]
            maps.append(AccuracyMap(target, (first, second), across, up, _weights(problem, target, grid)))
    return maps


def _pairs(problem: DesignProblem) -> list[tuple[int, int]]:
    robot = problem.loaded.robot
    count = len(robot.configuration)
    if tuple(robot.configuration) == robot.coordinates.pose:
        return [(i, j) for i in range(count) for j in range(i + 1, count) if j < robot.coordinates.translations]
    return [(i, i + 1) for i in range(count - 1)]


def _range(problem: DesignProblem) -> tuple[FloatArray, FloatArray]:
    """Least and largest value of every coordinate among poses to measure at and targets, shape (n_q,) each."""
    low, high = (ends[: problem.space.n_pose] for ends in problem.space.ranges)
    targets = problem.targets.configurations
    return np.minimum(low, targets.min(axis=0)), np.maximum(high, targets.max(axis=0))


def _weights(problem: DesignProblem, target: int, grid: FloatArray) -> FloatArray:
    robot = problem.loaded.robot
    loaded, parameters = problem.target_loads[target]
    measured = loaded.measure(grid, np.broadcast_to(parameters, (*grid.shape[:-1], len(parameters))))
    usable = (measured.jacobians.condition <= CONDITION_LIMIT) & (robot.limit_excess(grid) <= LIMIT_MARGIN)
    observation = measured.observation
    if problem.config["targets"][target].get("tolerance_axes") == "body":
        observation = body_axes(robot, grid) @ observation
    # An actuator that carries nothing there (a joint about the vertical) has a column of rounding errors.
    size = np.abs(observation).max(axis=-2) * loaded.scale
    carries = size > _IDLE * size.max(axis=-1, keepdims=True)
    observation = np.where(carries[..., None, :], observation, 0.0)
    rows = np.where(usable[..., None, None], observation, np.nan)
    importance = problem.targets.importance[target]
    weight: FloatArray = np.einsum("i,vuip,vuiq->vupq", importance, rows, rows)
    return weight
