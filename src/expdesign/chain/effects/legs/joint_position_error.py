"""A joint is not where the geometry says, so that both the true pose and the lever arms differ."""

from enum import StrEnum

import casadi as ca

from expdesign.chain.component import Component, each_leg
from expdesign.chain.declaration import Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.mechanics.robots.robot import Robot


class LegEnd(StrEnum):
    """At which end of a leg."""

    BASE = "base"
    PLATFORM = "platform"


class JointPositionError(Effect):
    """True minus nominal position of a leg's `base` or `platform` joint (variant), in the frame it is fixed to."""

    physics = "joint_position_error"
    declared = Declaration(
        left_out="a joint or link not where the geometry has it",
        phrase="wrong geometry at {component}",
        usually="machining and assembly",
        port="geometry",
        inputs=(Input.PLACE,),
        sizes=(
            Size("leg_*", 1e-4, "assumed: legs zeroed to 0.1 mm"),
            Size("*", 1e-4, "assumed: machined and assembled to 0.1 mm, not calibrated"),
        ),
    )
    changes_geometry = True

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return each_leg(robot) if cls.variants(robot) else []

    @classmethod
    def variants(cls, robot: Robot) -> list[Variant]:
        names = robot.inverse_kinematics.geometry_names if robot.on_legs else ()
        return [end for end in LegEnd if f"{end} 1 x" in names]

    def describe(self) -> tuple[Parameter, ...]:
        axes = self.robot.coordinates.axes
        return tuple(Parameter(f"joint_d{axis}_m", 1e-3, low=-0.1, high=0.1) for axis in axes)

    def geometry(self, geometry: ca.SX, theta: ca.SX) -> ca.SX:
        names = self.robot.inverse_kinematics.geometry_names
        moved = ca.SX(geometry)
        for axis, parameter in zip("xyz", range(theta.shape[0]), strict=False):
            index = names.index(f"{self.variant} {self.component.number} {axis}")
            moved[index] = moved[index] + theta[parameter]
        return moved

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        offsets = ", ".join(f"{1e3 * v[0]:.2f}" for v in values.values())
        return f"The {self.variant} joint of {self.component} lies ({offsets}) mm from its nominal position."
