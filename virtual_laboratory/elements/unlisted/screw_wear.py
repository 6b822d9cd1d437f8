"""A leg whose screw is worn where it is used most."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp
from typing import ClassVar

from ...legs import Leg, LegConditions
from ..element import require
from .law import LegPhysics


@dataclass(frozen=True)
class ScrewWear(LegPhysics):
    """The thread has lost its preload over the stretch on which the machine works most, and is softer there.

    Wear of ball screws follows the sliding distance (Archard), so it is local; what is lost first is preload and with
    it contact stiffness. Elongation N/k softening exp(-((q - centre)/width)^2 / 2). Accepted: the leg.
    """

    identifier: ClassVar[str] = "screw_wear"
    abscissa: ClassVar[str] = "length"
    softening: float
    centre_m: float
    width_m: float

    def __post_init__(self) -> None:
        require(self.width_m > 0, "width_m: must be positive")

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        return force * (self.curve(conditions.length, leg) - 1.0 / leg.stiffness)

    def curve(self, at: float, leg: Leg) -> float:
        return (1.0 + self.softening * exp(-(((at - self.centre_m) / self.width_m) ** 2) / 2)) / leg.stiffness
