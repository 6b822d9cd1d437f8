"""Play that is taken up gradually."""

from __future__ import annotations

from dataclasses import dataclass
from math import tanh
from typing import ClassVar

from ...legs import Leg, LegConditions
from ..unlisted.law import LegPhysics


@dataclass(frozen=True)
class SmearedBacklash(LegPhysics):
    """Play whose flanks meet one after another: gap_m/2 tanh(N/seat_N) in place of a jump.

    Many teeth, balls or threads with unequal gaps add up to a rounded transition. Accepted: the leg; its name is
    `leg_backlash`, and `leg_nonlinear_stiffness` where it is taken up over much of the load.
    """

    identifier: ClassVar[str] = "smeared_backlash"
    also: ClassVar[tuple[str, ...]] = ("leg_backlash", "leg_nonlinear_stiffness")
    abscissa: ClassVar[str] = "force"
    gap_m: float
    seat_N: float

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        return self.curve(force, leg)

    def curve(self, at: float, leg: Leg) -> float:
        return self.gap_m / 2 * tanh(at / self.seat_N)
