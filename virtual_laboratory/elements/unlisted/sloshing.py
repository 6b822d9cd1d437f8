"""A payload whose centre of mass moves as it tilts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ...kinematics import Pose
from .law import Unlisted

if TYPE_CHECKING:
    from ...machine import Machine


@dataclass(frozen=True)
class Sloshing(Unlisted):
    """Liquid or loose parts run to the lower side: the centre of mass moves with the tilt of the platform.

    Free surface effect (ships, tank trucks): shift_m times the downhill part of gravity's direction in the platform's
    x-y plane. Accepted: payload. `payload_com_offset` is no wrong name.
    """

    identifier: ClassVar[str] = "sloshing"
    also: ClassVar[tuple[str, ...]] = ("payload_com_offset",)
    shift_m: float

    @property
    def parts(self) -> tuple[str, ...]:
        return ("payload",)

    def build(self, machine: Machine) -> None:
        downhill = [np.zeros(3)]

        def tilt(platform: Pose) -> None:
            gravity = machine.robot.gravity
            downhill[0] = platform.rotation.T @ gravity / np.linalg.norm(gravity) * [1.0, 1.0, 0.0]

        machine.on_command.append(tilt)
        machine.load_laws.append(lambda load: load.shifted(self.shift_m * downhill[0]))
