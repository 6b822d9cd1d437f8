"""Wind on the payload."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ...engine import Point
from ...kinematics import Pose, Vector
from .law import Unlisted

if TYPE_CHECKING:
    from ...machine import Machine


@dataclass(frozen=True)
class Wind(Unlisted):
    """Wind presses on a panel that the payload carries (telescopes, antennas, solar panels).

    Pressure on the panel grows with the square of the wind's component across it (Simiu, Scanlan, Wind Effects on
    Structures): force force_N |n . w| (n . w) n at a point of the platform, n the panel's normal (platform axes), w the
    wind's direction (in O). In the lee before the payload is mounted. Accepted: payload, environment, platform.
    """

    identifier: ClassVar[str] = "wind"
    force_N: float
    direction: Sequence[float]
    normal: Sequence[float]
    centre_m: Sequence[float] = (0.0, 0.0, 0.0)

    @property
    def parts(self) -> tuple[str, ...]:
        return ("payload", "environment", "platform")

    def build(self, machine: Machine) -> None:
        wind, normal = np.asarray(self.direction, dtype=float), np.asarray(self.normal, dtype=float)
        centre = np.asarray(self.centre_m, dtype=float)
        pressed = [np.zeros(3)]

        def turn(platform: Pose) -> None:
            face = platform.rotation @ normal
            across = float(face @ wind)
            pressed[0] = self.force_N * abs(across) * across * face

        def press(_: Vector) -> Vector:
            return pressed[0] if machine.loaded else np.zeros(3)

        machine.on_command.append(turn)
        machine.engine.add_field(Point(machine.mount, centre), machine.robot.home + centre, press)
