"""Physics of the surroundings that a diagnosis can only call `unknown`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..engine import Point
from ..kinematics import Pose, Vector
from .element import Element, Stage, require

if TYPE_CHECKING:
    from ..machine import Machine


@dataclass
class Region:
    """Poses within `radius` (m) of a position (m, pose coordinates); everywhere when the radius is None."""

    centre: Vector
    radius: float | None

    def holds(self, platform: Pose, home: Vector) -> bool:
        return self.radius is None or float(np.linalg.norm(platform.position - home - self.centre)) <= self.radius


@dataclass(frozen=True)
class LooseMount(Element):
    """The payload mount is clamped; beyond a sideways load it slips by its clearance.

    The mount is a body on a stiff bushing (`stiffness_N_per_m`). When the force that it carries in the
    platform's x-y plane exceeds `holding_N` it moves by `slip_m` along it, and stays there until it slips
    again or the next series. The region is a ball of `radius_m` around `centre_m` (m, pose coordinates);
    None: everywhere.
    """

    identifier: ClassVar[str] = "loose_mount"
    stage: ClassVar[Stage] = Stage.BODIES
    holding_N: float
    slip_m: float
    centre_m: Sequence[float] = (0.0, 0.0, 0.0)
    radius_m: float | None = None
    stiffness_N_per_m: float = 1e9

    def __post_init__(self) -> None:
        require(self.holding_N >= 0, "holding_N: must be >= 0")

    def build(self, machine: Machine) -> None:
        engine = machine.engine
        plate, mount = machine.mount, engine.add_body(machine.robot.home, lambda platform: platform)
        k = self.stiffness_N_per_m
        origin = np.zeros(3)
        bushing = engine.add_bushing(Point(plate, origin), Point(mount, origin), np.diag([k, k, k, k, k, k]))
        machine.mount = mount
        slider = _Slider(self, Region(np.asarray(self.centre_m, dtype=float), self.radius_m))

        def reset(platform: Pose) -> None:
            slider.offset = np.zeros(6)
            slider.free = slider.region.holds(platform, machine.robot.home)
            engine.set_bushing_offset(bushing, slider.offset)

        def adjust() -> float:
            below, above = engine.pose(plate), engine.pose(mount)
            moved = slider.slip(below.rotation.T @ (above.position - below.position))
            engine.set_bushing_offset(bushing, slider.offset)
            return moved

        machine.on_command.append(reset)
        machine.adjusters.append(adjust)


@dataclass
class _Slider:
    mount: LooseMount
    region: Region
    free: bool = False
    offset: Vector = field(default_factory=lambda: np.zeros(6))

    def slip(self, displacement: Vector) -> float:
        """Slip according to the force that the bushing carries; how far (m)."""
        sideways = self.mount.stiffness_N_per_m * (displacement[:2] - self.offset[:2])
        size = float(np.hypot(*sideways))
        if not self.free or size <= self.mount.holding_N:
            return 0.0
        wanted = np.zeros(6)
        wanted[:2] = self.mount.slip_m * sideways / size
        moved = float(np.abs(wanted - self.offset).max())
        # The direction of a slip follows the force to rounding only; a picometre is close enough.
        if moved > 1e-12:
            self.offset = wanted
            return moved
        return 0.0


@dataclass(frozen=True)
class Cable(Element):
    """A cable from the base to the platform: it pulls with k (L - slack_m) once it is taut, and cannot push.

    `base_m` in O, `platform_m` in P (m), `stiffness_N_per_m`. With `on_payload` it comes with the payload and
    is absent from the unloaded reference.
    """

    identifier: ClassVar[str] = "cable"
    base_m: Sequence[float]
    platform_m: Sequence[float]
    slack_m: float
    stiffness_N_per_m: float
    on_payload: bool = True

    def build(self, machine: Machine) -> None:
        def tension(length: float) -> float:
            if self.on_payload and not machine.loaded:
                return 0.0
            return self.stiffness_N_per_m * max(length - self.slack_m, 0.0)

        start = Point(machine.base, np.asarray(self.base_m, dtype=float))
        end = Point(machine.mount, np.asarray(self.platform_m, dtype=float))
        machine.engine.add_spring(start, end, self.stiffness_N_per_m, tension)


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
