"""A joint that is not where the geometry says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from ..robot import Robot
from .element import Element, legs_of, require

if TYPE_CHECKING:
    pass

ENDS = ("base", "platform")


@dataclass(frozen=True)
class JointPositionError(Element):
    """A joint is off its nominal place by `[dx_m, dy_m, dz_m]` (m; base end: in O, platform end: in P).

    The controller does not know: it computes the leg lengths with the nominal geometry.
    """

    identifier: ClassVar[str] = "joint_position_error"
    component: str
    end: str = "base"
    dx_m: float = 0.0
    dy_m: float = 0.0
    dz_m: float = 0.0

    def __post_init__(self) -> None:
        require(self.end in ENDS, f"end: must be base or platform, not {self.end!r}")

    def true_geometry(self, robot: Robot) -> Robot:
        base, platform = robot.base_joints.copy(), robot.platform_joints.copy()
        moved = base if self.end == "base" else platform
        moved[legs_of(self.component, robot.legs)] += [self.dx_m, self.dy_m, self.dz_m]
        return robot.with_joints(base, platform)
