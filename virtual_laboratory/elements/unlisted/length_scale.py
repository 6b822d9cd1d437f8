"""A leg whose encoder has a wrong scale."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...legs import Leg, LegConditions
from .law import LegPhysics


@dataclass(frozen=True)
class LengthScale(LegPhysics):
    """A leg moves farther than commanded: the controller holds another lead or gear ratio than is built in.

    A screw of 5 mm lead entered as one of 4 mm moves a quarter too far; small lead errors are stated per travel (ISO
    3408-3: v300). The true pose is another one, and with it the directions of all legs. Longer by scale (q - zero_m),
    loaded or not. Accepted: the leg, `geometry`. `joint_position_error` is no wrong name, as the true pose is not the
    commanded one.
    """

    identifier: ClassVar[str] = "length_scale"
    also: ClassVar[tuple[str, ...]] = ("joint_position_error",)
    scale: float
    zero_m: float

    @property
    def parts(self) -> tuple[str, ...]:
        return (self.component, "geometry")

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        return self.scale * (conditions.length - self.zero_m)
