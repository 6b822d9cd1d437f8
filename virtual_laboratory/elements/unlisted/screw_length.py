"""A leg whose stiffness depends on how far it is extended."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from ...legs import Leg, LegConditions
from .law import LegPhysics

if TYPE_CHECKING:
    pass


@dataclass(frozen=True)
class ScrewLength(LegPhysics):
    """The free screw between bearing and nut is longer in an extended leg, so the leg is softer there.

    A screw fixed at one end is a rod whose compliance l/(E A) grows with its free length l (Slocum, Precision Machine
    Design, 1992, ch. 10; catalogues of ball screws state it as the axial rigidity of the shaft). Elongation
    N/k slope_per_m (q - middle_m). Accepted: the leg.
    """

    identifier: ClassVar[str] = "screw_length"
    abscissa: ClassVar[str] = "length"
    slope_per_m: float
    middle_m: float

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        return force / leg.stiffness * self.slope_per_m * (conditions.length - self.middle_m)

    def curve(self, at: float, leg: Leg) -> float:
        return (1.0 + self.slope_per_m * (at - self.middle_m)) / leg.stiffness
