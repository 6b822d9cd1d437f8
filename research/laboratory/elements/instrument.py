"""Instruments that show something else, and recordings that were spoilt."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..kinematics import Pose, Vector, rotation_about
from .element import Element, require


@dataclass(frozen=True)
class InstrumentMisalignment(Element):
    """The instrument's axes are those of O turned by the rotation vector [rot_x_rad, rot_y_rad, rot_z_rad].

    With Q that rotation, a position p is shown as Q^T p and an orientation R as Q^T R Q (the target on the
    platform was aligned to the same axes).
    """

    identifier: ClassVar[str] = "instrument_misalignment"
    rot_x_rad: float = 0.0
    rot_y_rad: float = 0.0
    rot_z_rad: float = 0.0

    def reading(self, pose: Pose) -> Pose:
        turn = rotation_about([self.rot_x_rad, self.rot_y_rad, self.rot_z_rad])
        return Pose(turn.T @ pose.position, turn.T @ pose.rotation @ turn)


@dataclass(frozen=True)
class InstrumentScale(Element):
    """Positions are shown too large, by 1 + scale_x, ... along the axes of O (0 = right)."""

    identifier: ClassVar[str] = "instrument_scale"
    scale_x: float = 0.0
    scale_y: float = 0.0
    scale_z: float = 0.0

    def reading(self, pose: Pose) -> Pose:
        return Pose(pose.position * (1.0 + np.array([self.scale_x, self.scale_y, self.scale_z])), pose.rotation)


@dataclass(frozen=True)
class InstrumentDistortion(Element):
    """The instrument's errors grow with the square of distance; outside the library of known effects.

    With r = p - `instrument_m` (m, in O): positions are shown as p + quadratic_per_m r^2 along each axis, and
    lines of sight bend, which lifts z by refraction_per_m (r_x^2 + r_y^2) (1/m).
    """

    identifier: ClassVar[str] = "instrument_distortion"
    instrument_m: Sequence[float] = (0.0, 0.0, 0.0)
    quadratic_per_m: Sequence[float] = (0.0, 0.0, 0.0)
    refraction_per_m: float = 0.0

    def reading(self, pose: Pose) -> Pose:
        r = pose.position - np.asarray(self.instrument_m, dtype=float)
        shift = np.asarray(self.quadratic_per_m, dtype=float) * r**2
        shift[2] += self.refraction_per_m * (r[0] ** 2 + r[1] ** 2)
        return Pose(pose.position + shift, pose.rotation)


@dataclass(frozen=True)
class Outlier(Element):
    """Single wrong recordings: rows that were written down with an error that belongs to no physics.

    Either the given `rows` (0 = first) or a random `fraction` of all. Each is off by `size` standard
    deviations in every measured component, with random signs; `size_m` and `size_rad` are used where there is
    no noise.
    """

    identifier: ClassVar[str] = "outlier"
    rows: Sequence[int] = ()
    fraction: float = 0.0
    size: float = 20.0
    size_m: float = 1e-5
    size_rad: float = 4e-5

    def __post_init__(self) -> None:
        require(0 <= self.fraction < 1, "fraction: must be between 0 and 1")

    def spoil(self, deflections: Vector, std: Vector, rng: np.random.Generator) -> Vector:
        count = len(deflections)
        require(all(0 <= row < count for row in self.rows), f"rows: the recordings have rows 0 ... {count - 1}")
        chosen = list(self.rows) or list(rng.permutation(count)[: round(self.fraction * count)])
        sizes = np.array([self.size_m] * min(3, len(std)) + [self.size_rad] * (len(std) - 3))
        sizes = np.where(std > 0, self.size * std, sizes)
        spoilt = deflections.copy()
        spoilt[chosen] += sizes * rng.choice([-1.0, 1.0], size=(len(chosen), len(std)))
        return spoilt
