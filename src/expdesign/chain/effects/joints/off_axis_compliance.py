"""A joint's gearbox and bearing yield off the joint's axis.

The base model's joint turns about its axis only. Its bearing also tilts under the moment across the axis: the arm
beyond it turns by C·P·M about the joint, M being the moment there and P the projection across the axis. A prismatic
joint's guide tilts about every direction. In positions the weight of the links beyond the joint tilts it too.
"""

from enum import StrEnum

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.arm import at_tip, links_of, moment_at, with_links_beyond
from expdesign.chain.component import Component
from expdesign.chain.components import each_joint, turning
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.robots.robot import Robot


class Directions(StrEnum):
    """Whether the bearing is the same across all directions."""

    ALL = ""
    TWO = "two directions"


class JointCompliance(Effect):
    """Variants: empty (the same across all directions) and `two directions`, fixed to the link before the joint."""

    physics = "joint_compliance"
    forms = tuple(Directions)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return each_joint(robot)

    def describe(self) -> tuple[Parameter, ...]:
        if self.variant is Directions.TWO:
            return tuple(Parameter(f"lateral_{i}_rad_per_Nm", 1e-6, low=0.0, high=1.0) for i in (1, 2))
        return (Parameter("lateral_rad_per_Nm", 1e-6, low=0.0, high=1.0),)

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        robot = links_of(self.robot)
        point, frame = robot.tree.joint_frame(row.pose, self.component.index)
        load = with_links_beyond(self.robot, wrench, row, self.component.number)
        first, second = across(robot.tree.joints[self.component.index].axis)
        compliances = theta[0] * ca.SX(np.outer(first, first)) + theta[-1] * ca.SX(np.outer(second, second))
        if not turning(self.robot, self.actuators) and self.variant is Directions.ALL:
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
