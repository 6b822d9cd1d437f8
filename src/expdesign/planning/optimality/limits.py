"""What keeps a measurement within the robot's limits, as smooth inequality rows with derivatives."""

from functools import cached_property

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.mechanics.robots.robot import CONDITION_LIMIT
from expdesign.mechanics.symbolic import BatchFunction
from expdesign.planning.problem import DesignProblem

MARGIN = 1e-8
"""Rows are kept this far below zero, so that a design at a limit is within it whatever the rounding."""
_NEAR_SINGULAR = 0.3
_STEP = 1e-6


class Limits:
    """Rows c ≤ 0 of single measurements: the legs' lengths (in parts of their stroke) and the condition (in decades).

    A robot that is not parallel gives one row, its `limit_excess` (m or rad).
    """

    def __init__(self, problem: DesignProblem) -> None:
        self._problem = problem
        self._robot = problem.loaded.robot
        space = problem.space
        columns = np.array([variable.columns[0] for variable in space.variables], dtype=np.int64)
        self._decisions = np.flatnonzero(~space.discrete & (columns < space.n_pose))
        self._coordinates = columns[self._decisions]

    @cached_property
    def _lengths(self) -> BatchFunction:
        closed_form = self._robot.inverse_kinematics
        pose = ca.SX.sym("X", closed_form.coordinates.n)
        lengths = closed_form.actuator_lengths(pose, ca.SX(closed_form.geometry))
        return BatchFunction("leg_lengths", [pose], [lengths, ca.jacobian(lengths, pose)])

    def rows(self, variables: FloatArray, *, condition_row: bool = True) -> tuple[FloatArray, FloatArray]:
        """Values c (..., r) and their gradients (..., r, g) at measurements with variables (..., g).

        Without `condition_row` that of the condition, the last one, is left at −1, as far from a singularity.
        """
        poses = self._problem.space.decode(variables)[0]
        values, by_pose = self._reach(poses)
        if condition_row:
            condition, by_condition = self._condition(poses)
        else:
            condition, by_condition = np.full(poses.shape[:-1], -1.0), np.zeros_like(poses)
        values = np.concatenate([values, condition[..., None]], axis=-1) + MARGIN
        by_pose = np.concatenate([by_pose, by_condition[..., None, :]], axis=-2)
        gradient = np.zeros((*values.shape, variables.shape[-1]))
        gradient[..., self._decisions] = by_pose[..., self._coordinates]
        return values, gradient

    def _reach(self, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
        if not self._robot.on_legs:
            return self._excess(poses)
        robot = self._robot.inverse_kinematics
        if robot.leg_length is None:
            return np.zeros((*poses.shape[:-1], 0)), np.zeros((*poses.shape[:-1], 0, poses.shape[-1]))
        shortest, longest = robot.leg_length
        lengths, rates = self._lengths(poses)
        stroke = longest - shortest
        values = np.concatenate([lengths - longest, shortest - lengths], axis=-1) / stroke
        return values, np.concatenate([rates, -rates], axis=-2) / stroke

    def _excess(self, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The one row of a robot that says only how far it is beyond its limits."""
        values = self._robot.limit_excess(poses)
        if not np.isfinite(values).all():
            return np.zeros((*poses.shape[:-1], 0)), np.zeros((*poses.shape[:-1], 0, poses.shape[-1]))
        gradient = _central(self._robot.limit_excess, poses)
        return values[..., None], gradient[..., None, :]

    def _condition(self, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
        """log10 of the scaled condition number over its limit; its gradient is needed only near the limit."""

        def decades(at: FloatArray) -> FloatArray:
            condition = self._robot.jacobians(at).condition
            values: FloatArray = np.log10(np.minimum(condition, 1e300) / CONDITION_LIMIT)
            return values

        values = decades(poses)
        gradient = np.zeros_like(poses)
        near = values > np.log10(_NEAR_SINGULAR)
        if near.any():
            gradient[near] = _central(decades, poses[near])
        return values, gradient


def _central(function: object, poses: FloatArray) -> FloatArray:
    """Central differences of a function of poses (..., n), shape (..., n)."""
    assert callable(function)
    steps = _STEP * np.eye(poses.shape[-1])
    difference: FloatArray = function(poses[..., None, :] + steps) - function(poses[..., None, :] - steps)
    return difference / (2.0 * _STEP)
