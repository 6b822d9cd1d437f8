"""The load of a row: a payload or a wrench, as a force, a moment and the point where the force acts."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from .kinematics import Matrix, Vector


@dataclass(frozen=True)
class Load:
    """Force (N) and moment (N m) along the axes of O; the force acts at `point` (m, platform axes)."""

    force: Vector
    moment: Vector
    point: Vector

    @classmethod
    def none(cls) -> Self:
        """No load."""
        return cls(np.zeros(3), np.zeros(3), np.zeros(3))

    @classmethod
    def payload(cls, mass: float, centre: Vector, gravity: Vector) -> Self:
        """Weight of a payload: m g at its centre of mass (kg; m, platform axes; m/s^2, in O)."""
        return cls(mass * gravity, np.zeros(3), centre)

    @classmethod
    def wrench(cls, force: Vector, moment: Vector) -> Self:
        """Wrench about the origin of P."""
        return cls(force, moment, np.zeros(3))

    @property
    def is_zero(self) -> bool:
        """Whether nothing is applied."""
        return not (self.force.any() or self.moment.any())

    def scaled(self, factor: float) -> Self:
        """The same load, `factor` times as large."""
        return replace(self, force=factor * self.force, moment=factor * self.moment)

    def shifted(self, offset: Vector) -> Self:
        """The same force at a point moved by `offset` (m, platform axes)."""
        return replace(self, point=self.point + offset)

    def turned(self, rotation: Matrix) -> Self:
        """Force and moment turned together about the axes of O."""
        return replace(self, force=rotation @ self.force, moment=rotation @ self.moment)

    def about_origin(self, rotation: Matrix) -> Self:
        """The same load as a wrench about the origin of P, at a platform orientation."""
        return replace(self, moment=self.moment + np.cross(rotation @ self.point, self.force), point=np.zeros(3))
