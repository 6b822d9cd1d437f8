"""A foot of the base that lifts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...kinematics import Vector
from ...legs import LegConditions
from .yielding import Yielding, YieldLaw


@dataclass(frozen=True)
class LiftingFoot(Yielding):
    """The base stands on feet that cannot pull: beyond an overturning moment one of them lifts and the base tilts.

    A base that only stands, as machines on levelling feet do; up to the moment its weight holds it down. Rotation
    tilting_rad_per_Nm max(m . axis - holding_Nm, 0) about a horizontal `axis` through the origin of O. Accepted: base.
    `base_compliance` is no wrong name.
    """

    identifier: ClassVar[str] = "lifting_foot"
    side: ClassVar[str] = "base"
    also: ClassVar[tuple[str, ...]] = ("base_compliance",)
    axis: Sequence[float]
    holding_Nm: float
    tilting_rad_per_Nm: float

    @property
    def parts(self) -> tuple[str, ...]:
        return ("base",)

    def law(self) -> YieldLaw:
        return _Foot(self)


@dataclass
class _Foot(YieldLaw):
    physics: LiftingFoot

    def offset(self, wrench: Vector, conditions: LegConditions) -> Vector:
        axis = np.asarray(self.physics.axis, dtype=float)
        beyond = max(float(wrench[3:] @ axis) - self.physics.holding_Nm, 0.0)
        return np.concatenate([np.zeros(3), self.physics.tilting_rad_per_Nm * beyond * axis])
