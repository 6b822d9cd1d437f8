"""A joint's gearbox and bearing yield off the joint's axis.

The base model's joint turns about its axis only. Its bearing also tilts under the moment across the axis: the arm
beyond it turns by C·P·M about the joint, M being the moment there and P the projection across the axis. A prismatic
joint's guide tilts about every direction. In positions the weight of the links beyond the joint tilts it too.
"""

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.arm import ArmEffect, arm_of, at_tip, moment_at, with_links_beyond
from expdesign.chain.components import each_joint
from expdesign.chain.effect import Parameter
from expdesign.chain.row import Row
from expdesign.recordings.recordings import LoadedPoints
from expdesign.robots.robot import Robot


class JointCompliance(ArmEffect):
    """Variants: empty (the same across all directions) and `two directions`, fixed to the link before the joint."""

    physics = "joint_compliance"

    @classmethod
    def places(cls, robot: Robot, points: LoadedPoints) -> list[tuple[str, str]]:
        return [(joint, variant) for joint in each_joint(robot) for variant in ("", "two directions")]

    def describe(self) -> tuple[Parameter, ...]:
        if self.variant == "two directions":
            return tuple(Parameter(f"lateral_{i}_rad_per_Nm", 1e-6, low=0.0, high=1.0) for i in (1, 2))
        return (Parameter("lateral_rad_per_Nm", 1e-6, low=0.0, high=1.0),)

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        robot = arm_of(self.robot)
        point, frame = robot.tree.joint_frame(row.pose, self.leg)
        load = with_links_beyond(robot, wrench, row, self.leg + 1)
        first, second = across(robot.tree.joints[self.leg].axis)
        compliances = theta[0] * ca.SX(np.outer(first, first)) + theta[-1] * ca.SX(np.outer(second, second))
        if not robot.revolute[self.leg] and self.variant != "two directions":
            compliances = theta[0] * ca.SX.eye(3)
        turn = frame @ compliances @ frame.T @ moment_at(load, row, point)
        return deflection + at_tip(ca.SX.zeros(3), turn, row, point)

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        listed = " and ".join(f"{1e6 * v[0]:.3g} ({1e6 * v[1]:.3g} to {1e6 * v[2]:.3g})" for v in values.values())
        return f"The bearing of {self.component} tilts across its axis by {listed} µrad per N·m."


def across(axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors (3,) across an axis and each other."""
    first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    first /= np.linalg.norm(first)
    return first, np.cross(axis, first)
