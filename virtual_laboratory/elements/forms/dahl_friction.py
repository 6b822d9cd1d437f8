"""Friction with presliding."""

from __future__ import annotations

from dataclasses import dataclass
from math import copysign, exp
from typing import ClassVar

from ...legs import Leg, LegConditions, LegLaw
from ..unlisted.law import LegPhysics


@dataclass(frozen=True)
class DahlFriction(LegPhysics):
    """Friction parallel to the spring that builds up over a distance, as Dahl's solid friction and LuGre at rest do.

    dF/dd = sigma (1 - F/F_c sign(dd)) (Dahl, AIAA J. 14 (1976) 1675; LuGre without velocity: Canudas de Wit et al.,
    IEEE Trans. Autom. Control 40 (1995) 419). Every series starts relaxed. Accepted: the leg; its name is
    `friction_hysteresis`.
    """

    identifier: ClassVar[str] = "dahl_friction"
    also: ClassVar[tuple[str, ...]] = ("friction_hysteresis",)
    friction_N: float
    bristle_N_per_m: float

    def law(self, leg: Leg) -> LegLaw:
        return _Bristles(self, leg)


@dataclass
class _Bristles(LegLaw):
    physics: DahlFriction
    leg: Leg
    whole: float = 0.0
    friction: float = 0.0

    def start(self, conditions: LegConditions) -> None:
        self.whole = self.friction = 0.0

    def elongation(self, force: float, conditions: LegConditions) -> float:
        return self._found(force) - force / self.leg.stiffness

    def accept(self, force: float, conditions: LegConditions) -> None:
        whole = self._found(force)
        self.whole, self.friction = whole, self._built(whole)

    def _built(self, whole: float) -> float:
        if self.physics.friction_N == 0:
            return 0.0
        step = whole - self.whole
        towards = copysign(self.physics.friction_N, step)
        fade = exp(-self.physics.bristle_N_per_m * abs(step) / self.physics.friction_N)
        return towards + (self.friction - towards) * fade

    def _found(self, force: float) -> float:
        """Whole elongation d with k d + F(d) = force; the sum grows with d, so halving intervals finds it."""
        k, most = self.leg.stiffness, self.physics.friction_N
        low, high = (force - most) / k, (force + most) / k
        for _ in range(80):
            middle = (low + high) / 2
            low, high = (middle, high) if k * middle + self._built(middle) < force else (low, middle)
        return (low + high) / 2
