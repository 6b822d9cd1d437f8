"""A link weighs something else than its URDF says (CAD masses without cables, covers or grease).

Own weight cancels from deflections, so that a link's mass shows in positions only, as a sag other than the assumed one.
"""

import casadi as ca

from expdesign.chain.arm import ArmEffect, arm_of
from expdesign.chain.effect import Parameter
from expdesign.chain.row import Row
from expdesign.recordings.recordings import LoadedPoints
from expdesign.robots.robot import Robot
from expdesign.robots.serial import SerialRobot

_LIGHTEST = 0.1
"""kg; a lighter link's error is not looked for."""


class LinkMassError(ArmEffect):
    """`link k`, with what hangs on it, weighs 1 + `relative_mass_error` times as much as assumed."""

    physics = "payload_mass_error"

    @classmethod
    def places(cls, robot: Robot, points: LoadedPoints) -> list[tuple[str, str]]:
        if not isinstance(robot, SerialRobot) or points.marker is None:
            return []
        return [(f"link {k + 1}", "") for k, mass in enumerate(robot.tree.masses()) if mass > _LIGHTEST]

    def describe(self) -> tuple[Parameter, ...]:
        return (Parameter("relative_mass_error", 0.1, low=-1.0, high=9.0),)

    def own_weight_change(self, row: Row, theta: ca.SX) -> ca.SX:
        robot = arm_of(self.robot)
        q = ca.SX.sym("q", len(robot.configuration))
        only = ca.SX([float(k == self.leg) for k in range(len(robot.stiffness))])
        torque = robot.own_weight_expression(q, row.gravity, factors=only)
        return theta[0] * ca.substitute(torque, q, row.pose)

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        v = values["relative_mass_error"]
        size = f"{100 * v[0]:+.1f} % ({100 * v[1]:+.1f} to {100 * v[2]:+.1f} %)"
        return f"{self.component.capitalize()}, with what hangs on it, is {size} heavier than the URDF says."
