"""An encoder with a local defect."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp
from typing import ClassVar

from ...legs import Leg, LegConditions
from .law import LegPhysics


@dataclass(frozen=True)
class EncoderDefect(LegPhysics):
    """A scratch or dirt on the scale: near one length the leg is not as long as its encoder says.

    Scales with local contamination show errors over a few signal periods to millimetres (makers state contamination
    tests). As with periodic errors, the reference of a series stands for the state that the command calls for:
    all rows of a series are offset by height_m exp(-((q - place_m)/width_m)^2 / 2). Accepted: the leg.
    """

    identifier: ClassVar[str] = "encoder_defect"
    height_m: float
    place_m: float
    width_m: float

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        if conditions.reference:
            return 0.0
        return self.height_m * exp(-(((conditions.length - self.place_m) / self.width_m) ** 2) / 2)
