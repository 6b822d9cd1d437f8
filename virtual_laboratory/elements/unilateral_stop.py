"""A support that touches; outside the library of known effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..engine import Point
from ..kinematics import Pose, Vector
from .element import Element
from .region import Region

if TYPE_CHECKING:
    from ..machine import Machine


@dataclass(frozen=True)
class UnilateralStop(Element):
    """A support stands near the platform and carries once the platform has come to it.

    It stands `clearance_m` (m) from a platform point.

    It is set anew for every series, against the commanded pose. `direction` (in O) points from the point
    to the stop; the stop pushes back with `stiffness_N_per_m` times the penetration. It may stand in one
    region of poses only.
    """

    identifier: ClassVar[str] = "unilateral_stop"
    platform_m: Sequence[float]
    clearance_m: float
    stiffness_N_per_m: float
    direction: Sequence[float] = (0.0, 0.0, -1.0)
    centre_m: Sequence[float] = (0.0, 0.0, 0.0)
    radius_m: float | None = None

    def build(self, machine: Machine) -> None:
        point = np.asarray(self.platform_m, dtype=float)
        normal = np.asarray(self.direction, dtype=float)
        normal = normal / np.linalg.norm(normal)
        region = Region(np.asarray(self.centre_m, dtype=float), self.radius_m)
        face = [np.inf]

        def reset(platform: Pose) -> None:
            there = region.holds(platform, machine.robot.home)
            face[0] = float(normal @ platform.point(point)) + self.clearance_m if there else np.inf

        def push(position: Vector) -> Vector:
            penetration = max(float(normal @ position) - face[0], 0.0)
            return np.asarray(-self.stiffness_N_per_m * penetration * normal)

        machine.engine.add_field(Point(machine.mount, point), np.zeros(3), push, self.stiffness_N_per_m)
        machine.on_command.append(reset)
