"""A leg whose seats settle under the first load."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...legs import Leg, LegConditions, LegLaw
from .law import LegPhysics


@dataclass(frozen=True)
class Seating(LegPhysics):
    """Seats and threads that were set anew settle under the largest load so far and keep the set.

    Embedding of bolted and threaded contacts (VDI 2230) flattens asperities up to the load reached and does not come
    back; each new command starts on fresh flanks. Elongation set_ratio times the extreme tension and compression of the
    series, over k. Accepted: the leg. `friction_hysteresis` (loading and unloading differ) is no wrong name.
    """

    identifier: ClassVar[str] = "seating"
    also: ClassVar[tuple[str, ...]] = ("friction_hysteresis",)
    set_ratio: float

    def law(self, leg: Leg) -> LegLaw:
        return _Set(self, leg)


@dataclass
class _Set(LegLaw):
    physics: Seating
    leg: Leg
    low: float = 0.0
    high: float = 0.0

    def start(self, conditions: LegConditions) -> None:
        self.low = self.high = 0.0

    def elongation(self, force: float, conditions: LegConditions) -> float:
        return self.physics.set_ratio * (min(self.low, force) + max(self.high, force)) / self.leg.stiffness

    def accept(self, force: float, conditions: LegConditions) -> None:
        self.low, self.high = min(self.low, force), max(self.high, force)
