"""A drive that holds less after a while."""

from __future__ import annotations

from dataclasses import dataclass
from math import isnan, tanh
from typing import ClassVar

from ...errors import LaboratoryError
from ...legs import Leg, LegConditions, LegLaw
from .law import LegPhysics


@dataclass(frozen=True)
class HoldingDroop(LegPhysics):
    """The drive lowers its holding current some time after a move, and its position stiffness with it.

    Stepper drives reduce the current at standstill after a set delay; servo drives do by their I2t limit. Elongation
    N/k ratio / (1 + exp(-(t - after_s)/width_s)), t the time since the series' start. Accepted: the leg. `creep` is no
    wrong name: deflection grows with time under load.
    """

    identifier: ClassVar[str] = "holding_droop"
    also: ClassVar[tuple[str, ...]] = ("creep",)
    ratio: float
    after_s: float
    width_s: float

    def law(self, leg: Leg) -> LegLaw:
        return _Droop(self, leg)


@dataclass
class _Droop(LegLaw):
    physics: HoldingDroop
    leg: Leg
    begun: float = 0.0

    def start(self, conditions: LegConditions) -> None:
        if isnan(conditions.time):
            raise LaboratoryError("holding_droop: the rows need the column time_s")
        self.begun = conditions.time

    def elongation(self, force: float, conditions: LegConditions) -> float:
        late = (conditions.time - self.begun - self.physics.after_s) / self.physics.width_s
        return force / self.leg.stiffness * self.physics.ratio * (1 + tanh(late / 2)) / 2
