"""Bearings and guides of an arm's joints, which yield off the joint's axis; play about the axis is in `backlash.py`."""

from dataclasses import replace

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import (
    ALL_JOINTS,
    Component,
    at_tip,
    each_joint,
    moment_at,
    sliding_joints,
    with_links_beyond,
)
from expdesign.chain.declaration import Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter, Values
from expdesign.chain.form import Form
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


def _lateral(*names: str) -> tuple[Parameter, ...]:
    return tuple(Parameter(f"{name}_rad_per_Nm", 1e-6, low=0.0, high=1.0) for name in names)


_ALIKE = Form(parameters=_lateral("lateral"))
"""The bearing is the same across all directions."""
_TWO = Form(name="two directions", parameters=_lateral("lateral_1", "lateral_2"))


class JointCompliance(Effect):
    """A joint's gearbox and bearing yield off the joint's axis.

    The base model's joint turns about its axis only. Its bearing also tilts under the moment across the axis: the arm
    beyond it turns by C·P·M about the joint, M being the moment there and P the projection across the axis. A prismatic
    joint's guide tilts about every direction. In positions the weight of the links beyond the joint tilts it too.
    Variants: empty (the same across all directions) and `two directions`, fixed to the link before the joint.

    Bearings of one make yield at all joints, each too little to be named by itself: `all joints` are one hypothesis
    with a compliance for every joint, the same across all directions.
    """

    identifier = "joints.off_axis_compliance"
    physics = "joint_compliance"
    declared = Declaration(
        left_out="a joint that yields off its axis",
        phrase="a soft bearing of {component}",
        usually="bearings and guides",
        port="joints",
        laws=("compliance",),
        inputs=(Input.FORCE, Input.PLACE),
        sizes=(
            Size(
                "*lateral*_rad_per_Nm",
                0.2,
                "assumed: a bearing is five times as stiff off the axis as the gear is about it",
                "actuator compliance",
            ),
        ),
    )
    forms = (_ALIKE, _TWO)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        joints = each_joint(robot)
        return [*joints, ALL_JOINTS] if len(joints) > 1 else joints

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        return [place for place in super().shown(robot, points) if not place[0].several or place[1] == _ALIKE]

    def describe(self) -> tuple[Parameter, ...]:
        if not self.component.several or self.variant == _TWO:
            return super().describe()
        return _lateral(*(f"joint_{joint.number}_lateral" for joint in each_joint(self.robot)))

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        if not self.component.several:
            return deflection + self._tilt(wrench, row, self.component.index, theta[0], theta[-1])
        tilts = (self._tilt(wrench, row, joint, theta[joint], theta[joint]) for joint in self.actuators)
        return sum(tilts, deflection)

    def _tilt(self, wrench: ca.SX, row: Row, joint: int, one: ca.SX, other: ca.SX) -> ca.SX:
        """Twist (6,) of the tip as the bearing of a joint (index from 0) tilts, with compliances in two directions."""
        robot = self.robot.links
        point, frame = robot.tree.joint_frame(row.pose, joint)
        load = with_links_beyond(self.robot, wrench, row, joint + 1)
        first, second = across(robot.tree.joints[joint].axis)
        compliances = one * ca.SX(np.outer(first, first)) + other * ca.SX(np.outer(second, second))
        if self.robot.units[joint] == "m" and self.variant == _ALIKE:
            compliances = one * ca.SX.eye(3)
        turn = frame @ compliances @ frame.T @ moment_at(load, row, point)
        return at_tip(self.robot, joint, ca.SX.zeros(3), turn, row, point)

    def sentence(self, values: Values) -> str:
        listed = " and ".join(f"{{{name}:1e6 .3g}}" for name in values)
        what = "bearing of {component} tilts across its axis"
        if self.component.several:
            what = "bearings of all joints tilt across their axes, from joint 1 on"
        return self.said(f"The {what} by {listed} µrad per N·m.", values)


def across(axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors (3,) across an axis and each other."""
    first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    first /= np.linalg.norm(first)
    return first, np.cross(axis, first)


class ExtensionCompliance(Effect):
    """A telescope's guide yields more the farther it is extended.

    The arm beyond a prismatic joint turns by (C₀ + C₁·q)·M about the joint, M being the moment there and q its
    coordinate: the bearings of a guide that overlaps less stand closer together. C₀ is `lateral_rad_per_Nm`, C₁ its
    change per metre of extension.
    """

    identifier = "joints.extension_compliance"
    physics = "joint_compliance"
    declared = replace(
        JointCompliance.declared,
        left_out="a joint that yields off its axis, the more the farther it is drawn out",
        usually="guides that overlap less",
        laws=(),
        sizes=(
            replace(JointCompliance.declared.sizes[0], parameter="lateral_rad_per_Nm"),
            Size(
                "lateral_change_rad_per_Nm_m",
                0.2,
                "assumed: over a metre of travel a guide's bearing loses what it has off the axis",
                "actuator compliance",
            ),
        ),
    )
    forms = (Form(name="with extension"),)

    at = sliding_joints
    quantities = (
        *_lateral("lateral"),
        Parameter("lateral_change_rad_per_Nm_m", 1e-6, low=-1.0, high=1.0),
    )
    says = (
        "The guide of {component} tilts by {lateral_rad_per_Nm.best:1e6 .3g} µrad per N·m, and by "
        "{lateral_change_rad_per_Nm_m:1e6 +.3g} more for every metre of extension."
    )

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        point, _ = self.robot.links.tree.joint_frame(row.pose, self.component.index)
        load = with_links_beyond(self.robot, wrench, row, self.component.number)
        turn = (theta[0] + theta[1] * row.lengths[self.component.index]) * moment_at(load, row, point)
        return deflection + at_tip(self.robot, self.component.index, ca.SX.zeros(3), turn, row, point)
