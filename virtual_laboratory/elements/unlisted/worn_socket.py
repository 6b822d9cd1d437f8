"""A ball joint that runs on the rim of its socket."""

from __future__ import annotations

from dataclasses import dataclass
from math import acos
from typing import ClassVar

from ...legs import Leg, LegConditions
from .law import LegPhysics


@dataclass(frozen=True)
class WornSocket(LegPhysics):
    """A worn ball joint carries on a full seat near home and on the socket's rim at large swivel angles.

    Contact compliance grows as the conformal seat is lost (Johnson, Contact Mechanics, 1985, sec. 5.3). Elongation
    N/k ratio max(swivel - seat_rad, 0)/span_rad, with the angle from the home direction. Accepted: the leg.
    """

    identifier: ClassVar[str] = "worn_socket"
    abscissa: ClassVar[str] = "swivel"
    ratio: float
    seat_rad: float
    span_rad: float

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        swivel = acos(min(max(float(conditions.direction @ conditions.home_direction), -1.0), 1.0))
        return force * (self.curve(swivel, leg) - 1.0 / leg.stiffness)

    def curve(self, at: float, leg: Leg) -> float:
        return (1.0 + self.ratio * max(at - self.seat_rad, 0.0) / self.span_rad) / leg.stiffness
