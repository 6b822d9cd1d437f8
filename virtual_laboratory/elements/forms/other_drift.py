"""Drift with time by other laws than a straight line."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, isnan, pi, sin
from typing import ClassVar

from ...errors import LaboratoryError
from ...legs import Leg, LegConditions
from ..element import require
from ..unlisted.law import LegPhysics

LAWS = ("saturating", "quadratic", "oscillating")


@dataclass(frozen=True)
class OtherDrift(LegPhysics):
    """A leg grows with time or temperature, but not in proportion.

    `saturating`: growth_m (1 - exp(-t/scale)) with t (s) since the start of the recordings (a drive that warms up; ISO
    230-3), `oscillating`: growth_m sin(2 pi t/scale) (an air conditioner), `quadratic`: growth_m ((T - T0)/scale)^2
    with T in degC (a compensated material, Invar). What shows is the change since the series' start. Accepted: the leg,
    environment; its name is `thermal_drift`.
    """

    identifier: ClassVar[str] = "other_drift"
    also: ClassVar[tuple[str, ...]] = ("thermal_drift",)
    kind: str
    growth_m: float
    scale: float
    origin: float = 0.0

    def __post_init__(self) -> None:
        require(self.kind in LAWS, f"kind: must be one of {', '.join(LAWS)}, not {self.kind!r}")
        require(self.scale > 0, "scale: must be positive")

    @property
    def parts(self) -> tuple[str, ...]:
        return (self.component, "environment")

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        at = conditions.temperature if self.kind == "quadratic" else conditions.time
        if isnan(at):
            raise LaboratoryError("other_drift: the rows need time_s or temperature_degC")
        x = (at - self.origin) / self.scale
        if self.kind == "saturating":
            return self.growth_m * (1.0 - exp(-x))
        return self.growth_m * (x**2 if self.kind == "quadratic" else sin(2 * pi * x))
