"""A vacuum bellows at the payload."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ...engine import Point
from ...kinematics import Vector
from .law import Unlisted

if TYPE_CHECKING:
    from ...machine import Machine


@dataclass(frozen=True)
class Bellows(Unlisted):
    """A bellows joins the payload to a chamber: the air presses on its area and its folds are a spring.

    Edge-welded bellows are used between vacuum chambers and hexapods; pressure thrust is p A and the spring follows the
    stroke. The force along `axis` (in O) is thrust_N - rate_N_per_m (travel . axis). It comes with the payload.
    Accepted: payload, platform, environment.
    """

    identifier: ClassVar[str] = "bellows"
    axis: Sequence[float]
    thrust_N: float
    rate_N_per_m: float
    platform_m: Sequence[float] = (0.0, 0.0, 0.0)

    @property
    def parts(self) -> tuple[str, ...]:
        return ("payload", "platform", "environment")

    def build(self, machine: Machine) -> None:
        axis, point = np.asarray(self.axis, dtype=float), np.asarray(self.platform_m, dtype=float)

        def push(travel: Vector) -> Vector:
            if not machine.loaded:
                return np.zeros(3)
            return np.asarray((self.thrust_N - self.rate_N_per_m * float(travel @ axis)) * axis)

        machine.engine.add_field(Point(machine.mount, point), machine.robot.home + point, push, self.rate_N_per_m)
