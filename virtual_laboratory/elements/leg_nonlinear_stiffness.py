"""Legs whose stiffness changes with their force."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import copysign, sqrt
from typing import ClassVar

from ..errors import LaboratoryError
from ..legs import Leg, LegConditions, LegLaw
from .element import Element, legs_of, require

LAWS = ("hertz", "cubic", "bilinear")


@dataclass(frozen=True)
class LegNonlinearStiffness(Element):
    """A leg's force is not proportional to its elongation, by one of three laws.

    `hertz`: a pair of ball contacts in series with the spring, preloaded against each other by `preload_N`. A
    contact squeezed by s carries (s/C)^(3/2), C = `contact_m_per_N23` (K. L. Johnson, Contact Mechanics,
    1985, eq. 4.23), so N = ((s0 + e)/C)^(3/2) - ((s0 - e)/C)^(3/2), the second while s0 > e. Without preload
    e = C |N|^(2/3) sign(N).
    `cubic`: N = k d (1 + `cubic_per_m2` d^2), d the leg's whole elongation: hardening > 0, softening < 0.
    `bilinear`: stiffness k (1 + `relative_change`) in compression, k in tension.
    """

    identifier: ClassVar[str] = "leg_nonlinear_stiffness"
    component: str
    law: str = "cubic"
    contact_m_per_N23: float = 0.0
    preload_N: float = 0.0
    cubic_per_m2: float = 0.0
    relative_change: float = 0.0

    def __post_init__(self) -> None:
        require(self.law in LAWS, f"law: must be one of {', '.join(LAWS)}, not {self.law!r}")
        require(
            self.contact_m_per_N23 >= 0 and self.preload_N >= 0,
            "contact_m_per_N23 and preload_N: must be >= 0",
        )
        require(self.relative_change > -1, "relative_change: must be above -1")

    def leg_laws(self, legs: Sequence[Leg]) -> Mapping[int, LegLaw]:
        return {index: self._law(legs[index]) for index in legs_of(self.component, len(legs))}

    def _law(self, leg: Leg) -> LegLaw:
        if self.law == "hertz":
            return _Hertz(self.contact_m_per_N23, self.preload_N)
        if self.law == "cubic":
            return _Cubic(leg, self.cubic_per_m2)
        return _Bilinear(leg, self.relative_change)


@dataclass
class _Hertz(LegLaw):
    contact: float
    preload: float

    def elongation(self, force: float, conditions: LegConditions) -> float:
        if force == 0 or self.contact == 0:
            return 0.0
        squeezed = self.contact * self.preload ** (2 / 3)

        def excess(elongation: float) -> float:
            pressed = ((squeezed + elongation) / self.contact) ** 1.5
            released = max(squeezed - elongation, 0.0) / self.contact
            return float(pressed - released**1.5 - abs(force))

        unloaded = self.contact * abs(force) ** (2 / 3)  # without preload, the most that it yields
        low, high = 0.0, unloaded
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if excess(middle) < 0 else (low, middle)
        return copysign((low + high) / 2, force)


@dataclass
class _Cubic(LegLaw):
    leg: Leg
    coefficient: float

    def elongation(self, force: float, conditions: LegConditions) -> float:
        k, b = self.leg.stiffness, self.coefficient
        linear = force / k
        if b < 0 and abs(linear) >= 2 / 3 * sqrt(-1 / (3 * b)):
            raise LaboratoryError(
                f"leg {self.leg.index + 1}: {force:.4g} N is beyond the peak of its softening law (cubic_per_m2)"
            )
        whole = linear
        for _ in range(60):
            change = (whole * (1 + b * whole**2) - linear) / (1 + 3 * b * whole**2)
            whole -= change
            if abs(change) < 1e-17:
                break
        return whole - linear


@dataclass
class _Bilinear(LegLaw):
    leg: Leg
    change: float

    def elongation(self, force: float, conditions: LegConditions) -> float:
        if force >= 0:
            return 0.0
        return force / self.leg.stiffness * (1 / (1 + self.change) - 1)
