"""Legs that share a supply."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...kinematics import Vector
from ...legs import Leg, LegConditions, LegLaw
from .law import Unlisted


@dataclass(frozen=True)
class SharedSupply(Unlisted):
    """All drives hang on one supply (hydraulic pressure, DC link) which sags with what all of them carry.

    The stiffness of each leg falls with the sum of all forces: elongation N/k sag (sum |N|)/typical_N. Accepted:
    `all legs`. `leg_nonlinear_stiffness` and `leg_coupling` are no wrong names.
    """

    identifier: ClassVar[str] = "shared_supply"
    also: ClassVar[tuple[str, ...]] = ("leg_nonlinear_stiffness", "leg_coupling")
    sag: float
    typical_N: float

    @property
    def parts(self) -> tuple[str, ...]:
        return ("all legs",)

    def leg_laws(self, legs: Sequence[Leg]) -> Mapping[int, LegLaw]:
        carried = np.zeros(len(legs))
        return {leg.index: _Fed(self, leg, carried) for leg in legs}


@dataclass
class _Fed(LegLaw):
    physics: SharedSupply
    leg: Leg
    carried: Vector  # what every leg carried in the pass before; one array for all

    def elongation(self, force: float, conditions: LegConditions) -> float:
        self.carried[self.leg.index] = abs(force)
        total = float(self.carried.sum()) / self.physics.typical_N
        return force / self.leg.stiffness * self.physics.sag * total
