"""A wire that holds the platform beside its legs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ...engine import Point
from ...kinematics import Pose
from .law import Unlisted

if TYPE_CHECKING:
    from ...machine import Machine


@dataclass(frozen=True)
class TautWire(Unlisted):
    """A preloaded wire or spring runs from the ground to the platform all the time, and carries part of every load.

    Counterbalances and preloading springs do so (Merlet, Parallel Robots, 2006, on wire preload). Tension
    preload_N + stiffness (L - L0), L0 the length at home: the platform's stiffness has a part that no leg has.
    Accepted: environment, platform.
    """

    identifier: ClassVar[str] = "taut_wire"
    post_m: Sequence[float]
    platform_m: Sequence[float]
    stiffness_N_per_m: float
    preload_N: float = 0.0

    @property
    def parts(self) -> tuple[str, ...]:
        return ("environment", "platform")

    def build(self, machine: Machine) -> None:
        post, point = np.asarray(self.post_m, dtype=float), np.asarray(self.platform_m, dtype=float)
        commanded = [1.0]

        def set_anew(platform: Pose) -> None:  # the counterbalance follows every command with the same preload
            commanded[0] = float(np.linalg.norm(platform.point(point) - post))

        def tension(length: float) -> float:
            return self.preload_N + self.stiffness_N_per_m * (length - commanded[0])

        machine.on_command.append(set_anew)
        start, end = Point(machine.engine.ground, post), Point(machine.mount, point)
        machine.engine.add_spring(start, end, self.stiffness_N_per_m, tension)
