"""A leg's passive joint, or its mount, yields differently along different directions.

Only the part of the yielding that lies along the leg changes its length: Δq = uᵀ·C·u·τ (the joint moves by −C·u·τ, and
∂q/∂a = −u). A C that is the same in all directions is confounded with the leg's own compliance; what shows is how the
apparent compliance changes as the leg turns against the frame in which C is fixed.
"""

import casadi as ca

from expdesign.chain.component import Component, each_leg
from expdesign.chain.declaration import Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.effects.legs.joint_position_error import LegEnd
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


class PassiveJointCompliance(Effect):
    """C without the entry that the leg's own compliance stands for; variants `base` and `platform` name the end."""

    physics = "passive_joint_compliance"
    declared = Declaration(
        left_out="anisotropic compliance of a leg's joint or its mount",
        phrase="soft passive joints of {component}",
        usually="universal and spherical joints, brackets",
        port="actuators",
        inputs=(Input.FORCE, Input.PLACE),
        sizes=(
            Size(
                "compliance_*",
                0.2,
                "assumed: a fifth of the leg's own compliance, which includes the mean of its joints",
                "actuator compliance",
            ),
        ),
    )

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return each_leg(robot) if robot.on_straight_legs else []

    @classmethod
    def variants(cls, robot: Robot) -> list[Variant]:
        # What a platform that does not turn is joined to yields as a base does.
        return list(LegEnd) if robot.coordinates.rotations else [LegEnd.BASE]

    def describe(self) -> tuple[Parameter, ...]:
        entries = ("xx", "yy", "xy", "xz", "yz") if self.robot.coordinates.translations > 2 else ("xx", "xy")
        # Differences to the leg's own compliance; a joint that yields by 1 mm under 1 N holds no leg.
        return tuple(Parameter(f"compliance_{entry}_m_per_N", 1e-8, low=-1e-3, high=1e-3) for entry in entries)

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        # A row of J⁻¹ begins with the direction of the leg.
        split = self.robot.coordinates.translations
        direction = row.inverse[self.component.index, :split].T
        if self.variant is LegEnd.PLATFORM:
            direction = row.rotation.T @ direction
        x, y = direction[0], direction[1]
        if split == 2:
            along = theta[0] * x**2 + 2.0 * theta[1] * x * y
        else:
            z = direction[2]
            along = theta[0] * x**2 + theta[1] * y**2 + 2.0 * (theta[2] * x * y + theta[3] * x * z + theta[4] * y * z)
        gained = ca.SX.zeros(elongation.shape[0])
        gained[self.component.index] = along * force[self.component.index]
        return elongation + gained, state

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        joint = f"{self.variant} joint of {self.component}"
        return f"The {joint}, or its mount, yields differently along different directions."
