"""Errors of orientation about the platform's own axes, whatever angles describe it (theory.md 9.C)."""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.mechanics.robots.robot import Robot


def body_axes(robot: Robot, poses: FloatArray) -> FloatArray:
    """S = blkdiag(I, Rᵀ·E) with E·α̇ = ω at poses (..., n) of a robot on legs, shape (..., n, n); NaN where singular.

    Translations stay along the axes of O; the rest is a small rotation about the axes of the platform frame.
    """
    split = robot.coordinates.translations
    jacobians = robot.jacobians(poses)
    exists = np.logical_and.reduce(np.isfinite(jacobians.pose), axis=(-2, -1), keepdims=True)
    pose = np.where(exists, jacobians.pose, np.eye(robot.coordinates.n))
    # The rotational rows of J = T⁻¹·J̌ give E, which depends on no actuator.
    rates = jacobians.forward @ np.linalg.inv(pose)
    axes = np.broadcast_to(np.eye(robot.coordinates.n), rates.shape).copy()
    axes[..., split:, split:] = jacobians.rotation.swapaxes(-1, -2) @ rates[..., split:, split:]
    result: FloatArray = np.where(exists, axes, np.nan)
    return result
