"""A mount that slips; outside the library of known effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..engine import Point
from ..kinematics import Pose, Vector
from .element import Element, Stage, require
from .region import Region

if TYPE_CHECKING:
    from ..machine import Machine


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
