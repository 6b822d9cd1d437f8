"""A force that depends on position; outside the library of known effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..engine import Point
from ..kinematics import Vector
from .element import Element

if TYPE_CHECKING:
    from ..machine import Machine


@dataclass(frozen=True)
class Attraction(Element):
    """A magnet at `magnet_m` (m, in O) pulls the payload at `platform_m` (m, in P).

    The force is force_N (distance_m / r)^2.

    Negative `force_N` pushes. It acts on the payload, so not in the unloaded reference.
    """

    identifier: ClassVar[str] = "attraction"
    magnet_m: Sequence[float]
    force_N: float
    distance_m: float
    platform_m: Sequence[float] = (0.0, 0.0, 0.0)

    def build(self, machine: Machine) -> None:
        def pull(displacement: Vector) -> Vector:
            if not machine.loaded:
                return np.zeros(3)
            r = float(np.linalg.norm(displacement))
            return -self.force_N * self.distance_m**2 / r**3 * displacement

        point = Point(machine.mount, np.asarray(self.platform_m, dtype=float))
        machine.engine.add_field(point, np.asarray(self.magnet_m, dtype=float), pull)
