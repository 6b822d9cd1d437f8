"""A base on rubber feet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...kinematics import Vector
from ...legs import LegConditions
from .yielding import Yielding, YieldLaw


@dataclass(frozen=True)
class RubberBase(Yielding):
    """The base stands on rubber that yields differently along and across and stiffens as it is squeezed.

    Rubber in compression stiffens with strain, in shear it hardly does (Lindley, Engineering Design with Natural
    Rubber). Displacement c_i f_i/(1 + |f_i|/stiffening_N) along each axis of O, and rotation about the origin of O by
    `tilting_rad_per_Nm` times m_i/(1 + |m_i|/stiffening_Nm). Accepted: base. `base_compliance` is no wrong name.
    """

    identifier: ClassVar[str] = "rubber_base"
    side: ClassVar[str] = "base"
    also: ClassVar[tuple[str, ...]] = ("base_compliance",)
    compliance_m_per_N: Sequence[float]
    stiffening_N: float
    tilting_rad_per_Nm: float = 0.0
    stiffening_Nm: float = 1.0

    @property
    def parts(self) -> tuple[str, ...]:
        return ("base",)

    def law(self) -> YieldLaw:
        return _Rubber(self)


@dataclass
class _Rubber(YieldLaw):
    physics: RubberBase

    def offset(self, wrench: Vector, conditions: LegConditions) -> Vector:
        rubber, force, moment = self.physics, wrench[:3], wrench[3:]
        along = np.asarray(rubber.compliance_m_per_N) * force / (1 + np.abs(force) / rubber.stiffening_N)
        about = rubber.tilting_rad_per_Nm * moment / (1 + np.abs(moment) / rubber.stiffening_Nm)
        return np.concatenate([along, about])
