"""A joint whose mount yields."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..engine import Body, Point
from ..kinematics import Matrix, Pose, Vector
from .element import Element, Stage, legs_of, require

if TYPE_CHECKING:
    from ..machine import Machine

ENDS = ("base", "platform")


@dataclass(frozen=True)
class PassiveJointCompliance(Element):
    """The mount of a leg's joint is a block on a bushing that yields differently along three directions.

    `stiffness_N_per_m`: three numbers along `axes`: `radial` (radially from the frame's z axis, tangentially,
    along z) or `frame` (x, y, z) of O for the base end, of P for the platform end; or a 3 x 3 matrix in them.
    """

    identifier: ClassVar[str] = "passive_joint_compliance"
    stage: ClassVar[Stage] = Stage.JOINTS
    component: str
    stiffness_N_per_m: Sequence[float] | Matrix
    end: str = "platform"
    axes: str = "radial"

    def __post_init__(self) -> None:
        require(self.end in ENDS, f"end: must be base or platform, not {self.end!r}")
        require(self.axes in ("radial", "frame"), f"axes: must be radial or frame, not {self.axes!r}")

    def build(self, machine: Machine) -> None:
        on_base = self.end == "base"
        joints = machine.robot.base_joints if on_base else machine.robot.platform_joints
        ends = machine.base_ends if on_base else machine.platform_ends
        stiffness = np.zeros((6, 6))
        given = np.asarray(self.stiffness_N_per_m, dtype=float)
        stiffness[:3, :3] = np.diag(given) if given.ndim == 1 else given
        stiffness[3:, 3:] = 1e4 * np.eye(3)  # nothing turns the block: the leg pulls at its centre
        for index in legs_of(self.component, len(machine.legs)):
            block = _block(machine, joints[index], on_base)
            axes = _radial_axes(joints[index]) if self.axes == "radial" else np.eye(3)
            point = Point(block, np.zeros(3))
            machine.engine.add_bushing(ends[index], point, stiffness, axes)
            ends[index] = point


def _block(machine: Machine, joint: Vector, on_base: bool) -> Body:
    if on_base:
        return machine.engine.add_body(joint, lambda _: Pose(joint, np.eye(3)))
    origin = machine.robot.home + joint
    return machine.engine.add_body(origin, lambda platform: Pose(platform.point(joint), platform.rotation))


def _radial_axes(joint: Vector) -> Matrix:
    radius = np.hypot(joint[0], joint[1])
    require(bool(radius > 0), "axes: a joint on the z axis has no radial direction; use frame")
    c, s = joint[0] / radius, joint[1] / radius
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
