"""A payload mount that is dragged along."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from ...kinematics import Vector
from ...legs import LegConditions
from .yielding import Yielding, YieldLaw


@dataclass(frozen=True)
class DraggingMount(Yielding):
    """A clamped payload micro-slips sideways and stays where it was dragged to.

    Prandtl's operator: displacement c p in the platform's x-y plane, where p follows the sideways force at a distance
    of `holding_N` (Prandtl, ZAMM 8 (1928) 85). Every series starts relaxed. Accepted: platform and payload.
    `friction_hysteresis` and `platform_compliance` are no wrong names.
    """

    identifier: ClassVar[str] = "dragging_mount"
    side: ClassVar[str] = "platform"
    also: ClassVar[tuple[str, ...]] = ("friction_hysteresis", "platform_compliance")
    compliance_m_per_N: float
    holding_N: float

    @property
    def parts(self) -> tuple[str, ...]:
        return ("platform", "payload")

    def law(self) -> YieldLaw:
        return _Dragged(self)


@dataclass
class _Dragged(YieldLaw):
    physics: DraggingMount
    follower: Vector = field(default_factory=lambda: np.zeros(2))

    def start(self, conditions: LegConditions) -> None:
        self.follower = np.zeros(2)

    def offset(self, wrench: Vector, conditions: LegConditions) -> Vector:
        found = np.zeros(6)
        found[:2] = self.physics.compliance_m_per_N * self._followed(wrench)
        return found

    def accept(self, wrench: Vector, conditions: LegConditions) -> None:
        self.follower = self._followed(wrench)

    def _followed(self, wrench: Vector) -> Vector:
        lead = wrench[:2] - self.follower
        ahead = float(np.hypot(*lead))
        if ahead <= self.physics.holding_N:
            return self.follower
        return np.asarray(self.follower + (1 - self.physics.holding_N / ahead) * lead)
