"""Dry friction in a leg: loading and unloading differ."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import ClassVar

from ..legs import Leg, LegConditions, LegLaw
from .element import Element, legs_of, require


@dataclass(frozen=True)
class FrictionHysteresis(Element):
    """Coulomb sliders parallel to the leg's spring (Jenkins elements; several of them: an Iwan model).

    W. D. Iwan, J. Appl. Mech. 33 (1966) 893: N = k d + sum_j clip(k_j (d - s_j), -F_j, F_j), where a slider
    that reaches its force F_j follows. `friction_N` is the sum of F_j (N); `sliders` of them share it as 1 :
    3 : 5 ... and the stiffness `contact_N_per_m` (N/m) equally; one slider with infinite stiffness is the
    rigid Coulomb element. Every series starts relaxed, all sliders at their middle.
    """

    identifier: ClassVar[str] = "friction_hysteresis"
    component: str
    friction_N: float
    contact_N_per_m: float = inf
    sliders: int = 1

    def __post_init__(self) -> None:
        require(self.friction_N >= 0, "friction_N: must be >= 0")
        require(self.contact_N_per_m > 0, "contact_N_per_m: must be positive")
        require(
            self.sliders == 1 or self.contact_N_per_m < inf,
            "sliders: several of them need a finite contact_N_per_m",
        )

    def leg_laws(self, legs: Sequence[Leg]) -> Mapping[int, LegLaw]:
        weights = [2 * j + 1 for j in range(self.sliders)]
        limits = [self.friction_N * weight / sum(weights) for weight in weights]
        stiffness = self.contact_N_per_m / self.sliders
        return {
            index: Sliders(legs[index].stiffness, stiffness, limits) for index in legs_of(self.component, len(legs))
        }


@dataclass
class Sliders(LegLaw):
    """Sliders that share a force, and where they stand."""

    spring: float
    contact: float
    limits: list[float]
    middles: list[float] = field(default_factory=list)

    def start(self, conditions: LegConditions) -> None:
        self.middles = [0.0] * len(self.limits)

    def elongation(self, force: float, conditions: LegConditions) -> float:
        return self._whole(force) - force / self.spring

    def accept(self, force: float, conditions: LegConditions) -> None:
        whole = self._whole(force)
        for j, limit in enumerate(self.limits):
            reach = limit / self.contact  # 0 for a rigid slider
            self.middles[j] = min(max(self.middles[j], whole - reach), whole + reach)

    def _whole(self, force: float) -> float:
        """Elongation d at which spring and sliders together carry the force; their sum grows with d."""
        if self.contact == inf:
            stuck, limit = self.middles[0], self.limits[0]
            carried = force - self.spring * stuck
            excess = max(abs(carried) - limit, 0.0)
            return stuck + (excess if carried > 0 else -excess) / self.spring
        # Piecewise linear and monotone: walk along its corners to the piece that holds the force.
        corners = sorted(
            middle + side * limit / self.contact
            for middle, limit in zip(self.middles, self.limits, strict=True)
            for side in (-1, 1)
        )
        below = [corner for corner in corners if self._force(corner) <= force]
        above = [corner for corner in corners if self._force(corner) > force]
        start = below[-1] if below else above[0] - 1.0
        end = above[0] if above else start + 1.0
        at_start, at_end = self._force(start), self._force(end)
        return start + (force - at_start) * (end - start) / (at_end - at_start)

    def _force(self, whole: float) -> float:
        sliders = zip(self.middles, self.limits, strict=True)
        return self.spring * whole + sum(min(max(self.contact * (whole - s), -f), f) for s, f in sliders)
