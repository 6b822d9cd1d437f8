"""Legs that grow with temperature or time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isnan
from typing import ClassVar

from ..errors import LaboratoryError
from ..legs import Leg, LegConditions, LegLaw
from .element import Element, legs_of


@dataclass(frozen=True)
class ThermalDrift(Element):
    """A leg grows by its strain: alpha_per_K (T - T0) + rate_per_s (t - t0), times its commanded length.

    T0, t0 are those of the first row of the series. T is the leg's own temperature (`leg1_degC` ...) or else
    `temperature_degC`; with `rate_per_s` alone it is a drift with time.
    """

    identifier: ClassVar[str] = "thermal_drift"
    component: str = "all legs"
    alpha_per_K: float = 0.0
    rate_per_s: float = 0.0

    def leg_laws(self, legs: Sequence[Leg]) -> Mapping[int, LegLaw]:
        return {index: _Strain(self) for index in legs_of(self.component, len(legs))}


@dataclass
class _Strain(LegLaw):
    drift: ThermalDrift
    origin: LegConditions | None = None

    def start(self, conditions: LegConditions) -> None:
        if self.drift.alpha_per_K and isnan(conditions.temperature):
            raise LaboratoryError("thermal_drift: the rows need temperature_degC or leg1_degC ...")
        if self.drift.rate_per_s and isnan(conditions.time):
            raise LaboratoryError("thermal_drift: the rows need time_s")
        self.origin = conditions

    def elongation(self, force: float, conditions: LegConditions) -> float:
        assert self.origin is not None
        strain = 0.0
        if self.drift.alpha_per_K:
            strain += self.drift.alpha_per_K * (conditions.temperature - self.origin.temperature)
        if self.drift.rate_per_s:
            strain += self.drift.rate_per_s * (conditions.time - self.origin.time)
        return strain * conditions.length
