"""A thin platform plate that stiffens as it dishes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...kinematics import Vector
from ...legs import LegConditions
from .yielding import Yielding, YieldLaw


@dataclass(frozen=True)
class DishingPlate(Yielding):
    """A thin plate bends in proportion at first and carries as a membrane when it has dished.

    Large deflections of plates (Timoshenko, Woinowsky-Krieger, Theory of Plates and Shells, ch. 13). Displacement along
    z of P compliance f/(1 + |f|/stiffening_N). Accepted: platform and payload (its mount). `platform_compliance` is no
    wrong name.
    """

    identifier: ClassVar[str] = "dishing_plate"
    side: ClassVar[str] = "platform"
    also: ClassVar[tuple[str, ...]] = ("platform_compliance",)
    compliance_m_per_N: float
    stiffening_N: float

    @property
    def parts(self) -> tuple[str, ...]:
        return ("platform", "payload")

    def law(self) -> YieldLaw:
        return _Plate(self)


@dataclass
class _Plate(YieldLaw):
    physics: DishingPlate

    def offset(self, wrench: Vector, conditions: LegConditions) -> Vector:
        found = np.zeros(6)
        found[2] = self.physics.compliance_m_per_N * wrench[2] / (1 + abs(wrench[2]) / self.physics.stiffening_N)
        return found
