"""A telescope's guide yields more the farther it is extended.

The arm beyond a prismatic joint turns by (C₀ + C₁·q)·M about the joint, M being the moment there and q its coordinate:
the bearings of a guide that overlaps less stand closer together.
"""

from typing import ClassVar

import casadi as ca

from expdesign.chain.component import Component, at_tip, moment_at, sliding_joints, with_links_beyond
from expdesign.chain.declaration import Declaration, Extension, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


class ExtensionCompliance(Effect):
    """`lateral_rad_per_Nm` at coordinate 0, and its change per metre of extension."""

    physics = "joint_compliance"
    declared = Declaration(
        left_out="a joint that yields off its axis, the more the farther it is drawn out",
        phrase="a soft bearing of {component}",
        usually="guides that overlap less",
        port="joints",
        inputs=(Input.FORCE, Input.PLACE),
        sizes=(
            Size(
                "lateral_rad_per_Nm",
                0.2,
                "assumed: a bearing is five times as stiff off the axis as the gear is about it",
                "actuator compliance",
            ),
            Size(
                "lateral_change_rad_per_Nm_m",
                0.2,
                "assumed: over a metre of travel a guide's bearing loses what it has off the axis",
                "actuator compliance",
            ),
        ),
    )
    forms: ClassVar[tuple[Variant, ...]] = tuple(Extension)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return sliding_joints(robot)

    def describe(self) -> tuple[Parameter, ...]:
        return (
            Parameter("lateral_rad_per_Nm", 1e-6, low=0.0, high=1.0),
            Parameter("lateral_change_rad_per_Nm_m", 1e-6, low=-1.0, high=1.0),
        )

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        point, _ = self.robot.links.tree.joint_frame(row.pose, self.component.index)
        load = with_links_beyond(self.robot, wrench, row, self.component.number)
        turn = (theta[0] + theta[1] * row.lengths[self.component.index]) * moment_at(load, row, point)
        return deflection + at_tip(self.robot, self.component.index, ca.SX.zeros(3), turn, row, point)

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        own, change = (values[name] for name in ("lateral_rad_per_Nm", "lateral_change_rad_per_Nm_m"))
        return (
            f"The guide of {self.component} tilts by {1e6 * own[0]:.3g} µrad per N·m, and by {1e6 * change[0]:+.3g} "
            f"({1e6 * change[1]:+.3g} to {1e6 * change[2]:+.3g}) more for every metre of extension."
        )
