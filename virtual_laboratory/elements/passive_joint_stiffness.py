"""Flexures: joints that resist rotation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..engine import Point
from ..kinematics import Pose, Vector, rotation_between
from .element import Element, Stage, legs_of, require

if TYPE_CHECKING:
    from ..machine import Machine


@dataclass(frozen=True)
class PassiveJointStiffness(Element):
    """Flexures instead of free joints: each end of a leg resists rotation.

    The stiffness `joint_Nm_per_rad` is the same about every axis.

    The leg becomes a rigid, telescoping strut that is pinned to both of its ends and joined to them by
    rotational springs, free of moment at the home pose. Bending, shear forces and torsion of the strut follow
    from that.
    """

    identifier: ClassVar[str] = "passive_joint_stiffness"
    stage: ClassVar[Stage] = Stage.STRUTS
    joint_Nm_per_rad: float
    component: str = "all legs"

    def __post_init__(self) -> None:
        require(self.joint_Nm_per_rad > 0, "joint_Nm_per_rad: must be positive")

    def build(self, machine: Machine) -> None:
        engine, robot = machine.engine, machine.robot
        rotational = np.diag([0.0, 0.0, 0.0, *[self.joint_Nm_per_rad] * 3])
        for index in legs_of(self.component, len(machine.legs)):
            start, end = robot.base_joints[index], robot.platform_joints[index]
            home = _direction(robot.pose(np.zeros(6)), start, end)

            def placement(platform: Pose, start: Vector = start, end: Vector = end, home: Vector = home) -> Pose:
                return Pose(start, rotation_between(home, _direction(platform, start, end)))

            strut = engine.add_body(start, placement)
            foot = Point(strut, np.zeros(3))
            head = Point(strut, robot.home + end - start)
            along = rotation_between(np.array([0.0, 0.0, 1.0]), home)
            engine.add_joint(machine.base_ends[index], foot, (1, 1, 1), np.eye(3))
            engine.add_joint(head, machine.platform_ends[index], (1, 1, 0), along)
            engine.add_bushing(machine.base_ends[index], foot, rotational)
            engine.add_bushing(head, machine.platform_ends[index], rotational)


def _direction(platform: Pose, start: Vector, end: Vector) -> Vector:
    span = platform.point(end) - start
    return np.asarray(span / np.linalg.norm(span))
