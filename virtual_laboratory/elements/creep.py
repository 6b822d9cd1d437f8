"""A leg that creeps under load."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import exp, isnan, nan
from typing import ClassVar

from ..errors import LaboratoryError
from ..legs import Leg, LegConditions, LegLaw
from .element import Element, legs_of, require


@dataclass(frozen=True)
class Creep(Element):
    """A leg creeps like a standard linear solid: its spring k in series with a Kelvin-Voigt element.

    Elongation N/k + z with tau dz/dt + z = creep_ratio N/k: under constant load the deflection grows from N/k
    towards (1 + creep_ratio) N/k with the time constant `tau_s`. A row's load is taken to be applied at the
    fraction `applied` of the time between the row before and itself: 0 (default) right after the row before,
    1 with no time to creep.
    """

    identifier: ClassVar[str] = "creep"
    component: str
    creep_ratio: float
    tau_s: float
    applied: float = 0.0

    def __post_init__(self) -> None:
        require(self.tau_s > 0, "tau_s: must be positive")
        require(self.creep_ratio > -1, "creep_ratio: must be above -1")
        require(0 <= self.applied <= 1, "applied: must be between 0 and 1")

    def leg_laws(self, legs: Sequence[Leg]) -> Mapping[int, LegLaw]:
        return {index: _KelvinVoigt(self, legs[index]) for index in legs_of(self.component, len(legs))}


@dataclass
class _KelvinVoigt(LegLaw):
    creep: Creep
    leg: Leg
    time: float = nan
    force: float = 0.0
    crept: float = 0.0

    def start(self, conditions: LegConditions) -> None:
        if isnan(conditions.time):
            raise LaboratoryError("creep: the rows need the column time_s")
        self.time, self.force, self.crept = conditions.time, 0.0, 0.0

    def elongation(self, force: float, conditions: LegConditions) -> float:
        passed = conditions.time - self.time
        if passed < 0:
            raise LaboratoryError("creep: time_s goes back within a series")
        before = self._relaxed(self.crept, self.force, self.creep.applied * passed)
        return self._relaxed(before, force, (1 - self.creep.applied) * passed)

    def accept(self, force: float, conditions: LegConditions) -> None:
        self.crept = self.elongation(force, conditions)
        self.time, self.force = conditions.time, force

    def _relaxed(self, crept: float, force: float, duration: float) -> float:
        """Exact solution of the Kelvin-Voigt element under a constant force."""
        end = self.creep.creep_ratio * force / self.leg.stiffness
        return end + (crept - end) * exp(-duration / self.creep.tau_s)
