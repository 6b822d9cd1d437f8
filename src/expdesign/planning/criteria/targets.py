"""Where accuracy under load is wanted, as arrays, and along which axes: errors of orientation may be told about the
platform's own, whatever angles describe it (theory.md 9.C).
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.mechanics.robots.robot import Robot

Aggregate = Literal["mean", "max"]


@dataclass(frozen=True)
class Targets:
    """Targets t with their loads, tolerances and weights.

    Attributes:
        configurations: X_D, shape (t, n_q).
        observation: S·A_D, the error along the axes of the tolerances, shape (t, n, n_p).
        importance: 1/tolerance² of each axis (1/m², 1/rad²), 0 where the axis does not matter, shape (t, n).
        weights: of each target in the mean, shape (t,).
        translations: how many leading axes are translations.
        aggregate: over targets, weighted mean of the squares or their maximum.
        axes: S, errors along the axes of the tolerances per error of the pose coordinates, shape (t, n, n); None where
            these are the same.
    """

    configurations: FloatArray
    observation: FloatArray
    importance: FloatArray
    weights: FloatArray
    translations: int
    aggregate: Aggregate = "mean"
    axes: FloatArray | None = None


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
