"""A bolted joint of the platform that opens."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...kinematics import Vector
from ...legs import LegConditions
from .yielding import Yielding, YieldLaw


@dataclass(frozen=True)
class OpeningBolt(Yielding):
    """The payload's flange is bolted down; above a moment the joint opens on one side and the flange tilts.

    Bolted joints are stiff until the clamped parts separate, then several times softer (VDI 2230; Bickford,
    Introduction to the Design and Behavior of Bolted Joints). Rotation opened_rad_per_Nm (|m| - holding_Nm) about the
    part of the moment m in the platform's x-y plane. Accepted: platform and payload (the joint is between them).
    `platform_compliance` is no wrong name.
    """

    identifier: ClassVar[str] = "opening_bolt"
    side: ClassVar[str] = "platform"
    also: ClassVar[tuple[str, ...]] = ("platform_compliance",)
    holding_Nm: float
    opened_rad_per_Nm: float

    @property
    def parts(self) -> tuple[str, ...]:
        return ("platform", "payload")

    def law(self) -> YieldLaw:
        return _Flange(self)


@dataclass
class _Flange(YieldLaw):
    physics: OpeningBolt

    def offset(self, wrench: Vector, conditions: LegConditions) -> Vector:
        found = np.zeros(6)
        size = float(np.hypot(wrench[3], wrench[4]))
        if size > self.physics.holding_Nm:
            found[3:5] = self.physics.opened_rad_per_Nm * (1 - self.physics.holding_Nm / size) * wrench[3:5]
        return found
