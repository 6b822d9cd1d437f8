"""Play that depends on where the nut stands."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, tanh
from typing import ClassVar

from ...legs import Leg, LegConditions
from .law import LegPhysics


@dataclass(frozen=True)
class PlaceBacklash(LegPhysics):
    """A screw or rack that is worn in the middle has play there and none at its ends.

    Rebuilt machine tools show it as lost motion that varies along the axis (ISO 230-2 reports reversal per position).
    Gap gap_m exp(-((q - worn_m)/width_m)^2 / 2), taken up over a force of `seat_N`. Accepted: the leg. `leg_backlash`
    is no wrong name.
    """

    identifier: ClassVar[str] = "place_backlash"
    also: ClassVar[tuple[str, ...]] = ("leg_backlash",)
    gap_m: float
    worn_m: float
    width_m: float
    seat_N: float = 1.0

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        gap = self.gap_m * exp(-(((conditions.length - self.worn_m) / self.width_m) ** 2) / 2)
        return gap / 2 * tanh(force / self.seat_N)
