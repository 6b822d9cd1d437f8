"""A leg with smooth hysteresis."""

from __future__ import annotations

from dataclasses import dataclass
from math import copysign, exp
from typing import ClassVar

from ...legs import Leg, LegConditions, LegLaw
from ..element import require
from .law import LegPhysics


@dataclass(frozen=True)
class BoucWen(LegPhysics):
    """A joint in the leg micro-slips: its elongation follows the force along a rounded loop.

    Wen, J. Eng. Mech. Div. 102 (1976) 249, with exponent 1 and beta = gamma, driven by the force: dz = (1 - |z|/z0) dN
    while |z| grows, dz = dN while it shrinks; elongation ratio z/k. Bolted and riveted joints do so (Ibrahim, Pettit,
    J. Sound Vib. 279 (2005) 857). Accepted: the leg. `friction_hysteresis` is no wrong name.
    """

    identifier: ClassVar[str] = "bouc_wen"
    also: ClassVar[tuple[str, ...]] = ("friction_hysteresis",)
    ratio: float
    saturation_N: float

    def __post_init__(self) -> None:
        require(self.saturation_N > 0, "saturation_N: must be positive")

    def law(self, leg: Leg) -> LegLaw:
        return _Loop(self, leg)


@dataclass
class _Loop(LegLaw):
    physics: BoucWen
    leg: Leg
    force: float = 0.0
    z: float = 0.0

    def start(self, conditions: LegConditions) -> None:
        self.force = self.z = 0.0

    def elongation(self, force: float, conditions: LegConditions) -> float:
        return self.physics.ratio * self._state(force) / self.leg.stiffness

    def accept(self, force: float, conditions: LegConditions) -> None:
        self.z, self.force = self._state(force), force

    def _state(self, force: float) -> float:
        step, z, limit = force - self.force, self.z, self.physics.saturation_N
        if z * step < 0:  # back to z = 0 in proportion
            if abs(step) <= abs(z):
                return z + step
            step, z = step + z, 0.0
        return copysign(limit - (limit - abs(z)) * exp(-abs(step) / limit), step if z == 0 else z)
