"""A hose that hangs from the payload."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ...engine import Point
from ...kinematics import Vector
from .law import Unlisted

if TYPE_CHECKING:
    from ...machine import Machine


@dataclass(frozen=True)
class Hose(Unlisted):
    """A hose or cable chain hangs between a post and the payload and pulls with the tension of its catenary.

    Shallow catenary of length `length_m` and weight `weight_N_per_m` (Irvine, Cable Structures, 1981): with the chord d
    the sag is sqrt(3 d (l - d)/8), the pull along the chord w d^2/(8 sag), and half of the weight hangs on the payload.
    It comes with the payload, so it is not in the unloaded reference. Accepted: payload, platform, environment.
    """

    identifier: ClassVar[str] = "hose"
    post_m: Sequence[float]
    platform_m: Sequence[float]
    length_m: float
    weight_N_per_m: float
    down: Sequence[float] = (0.0, 0.0, -1.0)

    @property
    def parts(self) -> tuple[str, ...]:
        return ("payload", "platform", "environment")

    def build(self, machine: Machine) -> None:
        down = np.asarray(self.down, dtype=float)

        def pull(chord: Vector) -> Vector:
            if not machine.loaded:
                return np.zeros(3)
            d = float(np.linalg.norm(chord))
            sag = sqrt(3 * d * max(self.length_m - d, 1e-3 * self.length_m) / 8)
            along = self.weight_N_per_m * d**2 / (8 * sag)
            return np.asarray(-along * chord / d + self.weight_N_per_m * self.length_m / 2 * down)

        point = Point(machine.mount, np.asarray(self.platform_m, dtype=float))
        machine.engine.add_field(point, np.asarray(self.post_m, dtype=float), pull)
