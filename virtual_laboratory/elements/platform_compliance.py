"""A payload mount that yields."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..engine import Point
from ..kinematics import Matrix
from .bushing import bushing_matrix
from .element import Element, Stage

if TYPE_CHECKING:
    from ..machine import Machine


@dataclass(frozen=True)
class PlatformCompliance(Element):
    """The payload mount is a body on a bushing on the joints' plate.

    It carries the load, and the instrument reads it.

    Bushing: three stiffnesses (N/m) and three rotational ones (N m/rad), or a 6 x 6 matrix, in platform axes
    at the point `at_m` (m, platform frame). Under a wrench at that point the mount moves by w/k against the
    plate.
    """

    identifier: ClassVar[str] = "platform_compliance"
    stage: ClassVar[Stage] = Stage.BODIES
    stiffness: Sequence[float] | Matrix
    at_m: Sequence[float] = (0.0, 0.0, 0.0)

    def build(self, machine: Machine) -> None:
        at = np.asarray(self.at_m, dtype=float)
        mount = machine.engine.add_body(machine.robot.home, lambda platform: platform)
        machine.engine.add_bushing(Point(machine.mount, at), Point(mount, at), bushing_matrix(self.stiffness))
        machine.mount = mount
