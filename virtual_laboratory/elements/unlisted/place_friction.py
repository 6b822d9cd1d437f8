"""Friction that depends on where the nut stands."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp
from typing import ClassVar

import numpy as np

from ...legs import Leg, LegConditions, LegLaw
from ..friction_hysteresis import Sliders
from .law import LegPhysics


@dataclass(frozen=True)
class PlaceFriction(LegPhysics):
    """A guide that is tight at one end: the breakaway force changes along the travel.

    Misaligned or bent screws bind where the offset is largest; makers state drag torque as a band along the travel (ISO
    3408-3). A rigid Coulomb slider of breakaway_N exp(-(q - tight_m)^2 / (2 width_m^2)) parallel to the spring.
    Accepted: the leg. `friction_hysteresis` is no wrong name.
    """

    identifier: ClassVar[str] = "place_friction"
    also: ClassVar[tuple[str, ...]] = ("friction_hysteresis",)
    breakaway_N: float
    tight_m: float
    width_m: float

    def law(self, leg: Leg) -> LegLaw:
        return _Slider(self, leg)


@dataclass
class _Slider(LegLaw):
    physics: PlaceFriction
    leg: Leg
    slider: Sliders | None = None

    def start(self, conditions: LegConditions) -> None:
        physics = self.physics
        limit = physics.breakaway_N * exp(-(((conditions.length - physics.tight_m) / physics.width_m) ** 2) / 2)
        self.slider = Sliders(self.leg.stiffness, np.inf, [limit])
        self.slider.start(conditions)

    def elongation(self, force: float, conditions: LegConditions) -> float:
        assert self.slider is not None
        return self.slider.elongation(force, conditions)

    def accept(self, force: float, conditions: LegConditions) -> None:
        assert self.slider is not None
        self.slider.accept(force, conditions)
