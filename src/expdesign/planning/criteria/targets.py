"""Where accuracy under load is wanted, as arrays, and along which axes: errors of orientation may be told about the
platform's own, whatever angles describe it (theory.md 9.C). Variances of the attained poses there, and how criteria sum
them up (4.3, 5.4, 6).
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.mechanics.differentiation import plain, square_root
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

    def blocks(self, rows: FloatArray) -> FloatArray:
        """√(w_t/Σw)·W_t^½·T_t of rows T (t, n, p) in blocks of which the worst counts, shape (blocks, q, p): one of all
        axes that matter where the mean over targets counts, or W_t^½·T_t of every target where the largest does.
        """
        weighted = np.sqrt(self.importance)[..., None] * rows
        if self.aggregate == "max":
            return weighted
        weighted = np.sqrt(self.weights / self.weights.sum())[:, None, None] * weighted
        return weighted[self.importance > 0.0][None]


PIECES = 6
"""Largest number of pieces of a maximum that are looked at at a time."""


class TargetVariances:
    """Variances at t targets, for any batch of designs.

    Attributes:
        targets: where accuracy is wanted.
        noise_variance: U_ii due to measurement noise (m², rad²), shape (..., t, n).
        force_variance: (Z·Σ_F·Zᵀ)_ii due to load errors (m², rad²), shape (..., t, n).
        place: which of the values in `largest` is taken, from 0; others than 0 are the further pieces of a maximum.
        pieces: how many pieces the criteria evaluated so far have.
    """

    targets: Targets
    noise_variance: FloatArray
    force_variance: FloatArray
    place: int = 0
    pieces: int = 1

    def weighted(self, variance: FloatArray) -> FloatArray:
        """Σ_i variance_ii/tol_i² per target, shape (..., t), from (..., t, n); NaN where an axis that matters is."""
        importance = self.targets.importance
        terms = variance * importance
        if not (importance > 0.0).all():
            terms = np.where(importance > 0.0, terms, 0.0)
        weighted: FloatArray = terms.sum(axis=-1)
        return weighted

    def aggregated(self, squares: FloatArray) -> FloatArray:
        """Root of the mean or maximum over targets of squares (..., t), shape (...)."""
        if self.targets.aggregate == "max":
            return square_root(self.largest(squares))
        return square_root((squares * (self.targets.weights / self.targets.weights.sum())).sum(axis=-1))

    def largest(self, values: FloatArray) -> FloatArray:
        """The largest of values (..., t), shape (...): the maximum of smooth pieces, where t are targets for example.

        A maximum is not differentiable where two values tie. Written with `largest`, its further pieces (the second
        largest value, …) can be evaluated one by one with `place`, as refinement by gradients and optimality
        conditions need them, up to `PIECES`; its own gradient is then that of the piece that comes first.
        """
        count = values.shape[-1]
        self.pieces = max(self.pieces, min(PIECES, count))
        order = np.argsort(-np.nan_to_num(plain(values)), axis=-1, kind="stable")
        chosen = np.arange(count) == order[..., min(self.place, count - 1), None]
        return (values * chosen).sum(axis=-1)


class GivenVariances(TargetVariances):
    """Variances that were computed elsewhere."""

    def __init__(self, targets: Targets, noise_variance: FloatArray, force_variance: FloatArray) -> None:
        self.targets, self.noise_variance, self.force_variance = targets, noise_variance, force_variance


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
