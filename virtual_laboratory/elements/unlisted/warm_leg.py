"""A leg that is softer when it is warm."""

from __future__ import annotations

from dataclasses import dataclass
from math import isnan
from typing import ClassVar

from ...errors import LaboratoryError
from ...legs import Leg, LegConditions
from .law import LegPhysics


@dataclass(frozen=True)
class WarmLeg(LegPhysics):
    """The compliance of a leg with a polymer member (coupling, damped strut) changes with temperature.

    Near their glass transition polymers lose several per cent of modulus per kelvin (Ferry, Viscoelastic Properties of
    Polymers, 1980). Elongation N/k slope_per_K (T - reference_degC). Accepted: the leg.
    """

    identifier: ClassVar[str] = "warm_leg"
    abscissa: ClassVar[str] = "temperature"
    slope_per_K: float
    reference_degC: float

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        if isnan(conditions.temperature):
            raise LaboratoryError("warm_leg: the rows need temperature_degC or leg1_degC ...")
        return force / leg.stiffness * self.slope_per_K * (conditions.temperature - self.reference_degC)

    def curve(self, at: float, leg: Leg) -> float:
        return (1.0 + self.slope_per_K * (at - self.reference_degC)) / leg.stiffness
