"""An arm's geometry is not the nominal one: a joint's zero is off, or a link's far end is not where it should be.

In deflections the error shows through the levers; in positions it shows directly.
"""

import casadi as ca

from expdesign.chain.arm import ArmEffect, arm_of
from expdesign.chain.components import each_joint, turning
from expdesign.chain.effect import Parameter
from expdesign.recordings.recordings import LoadedPoints
from expdesign.robots.kinematic_tree import FRAME_AXES
from expdesign.robots.robot import Robot

_LENGTH, _ANGLE = 0.005, 0.02
"""m, rad; how well links are made (standard deviation), which holds what deflections do not determine."""


class ArmGeometry(ArmEffect):
    """`joint k`: offset of its zero. `link k`: true minus nominal frame at its far end, in that frame (m, rad)."""

    physics = "joint_position_error"
    changes_geometry = True

    @classmethod
    def places(cls, robot: Robot, points: LoadedPoints) -> list[tuple[str, str]]:
        if points.marker is not None:
            return []  # positions are `geometric_error`'s, which knows what they cannot tell apart
        joints = each_joint(robot)
        return [(joint, "offset") for joint in joints] + [(f"link {k + 1}", "frame") for k in range(len(joints))]

    def describe(self) -> tuple[Parameter, ...]:
        if self.component.startswith("link"):
            units = [("m", 0.1, _LENGTH) if len(axis) == 1 else ("rad", 0.5, _ANGLE) for axis in FRAME_AXES]
            return tuple(
                Parameter(f"frame_{axis}_{unit}", 1e-3, low=-high, high=high, spread=spread)
                for axis, (unit, high, spread) in zip(FRAME_AXES, units, strict=True)
            )
        if turning(self.robot, self.legs):
            return (Parameter("offset_rad", 1e-3, low=-0.5, high=0.5),)
        return (Parameter("offset_m", 1e-3, low=-0.5, high=0.5),)

    def geometry(self, geometry: ca.SX, theta: ca.SX) -> ca.SX:
        tree = arm_of(self.robot).tree
        first = tree.link_frame(self.leg + 1, "x") if self.component.startswith("link") else self.leg
        moved = ca.SX(geometry)
        for index in range(theta.shape[0]):
            moved[first + index] = moved[first + index] + theta[index]
        return moved

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        if self.component.startswith("joint"):
            name, v = next(iter(values.items()))
            unit = "mrad" if name == "offset_rad" else "mm"
            size = f"{1e3 * v[0]:.3g} ({1e3 * v[1]:.3g} to {1e3 * v[2]:.3g})"
            return f"The zero of {self.component} is off by {size} {unit}."
        listed = ", ".join(f"{1e3 * v[0]:.2f}" for v in values.values())
        return f"The far end of {self.component} is not where it should be: ({listed}) mm and mrad in its own frame."
