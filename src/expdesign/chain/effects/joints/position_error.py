"""An arm's geometry is not the nominal one: a joint's zero is off, or a link's far end is not where it should be.

In deflections the error shows through the levers; in positions it shows directly.
"""

from enum import StrEnum

import casadi as ca

from expdesign.chain.component import Component, Part, each_joint, each_link, turning
from expdesign.chain.declaration import LOOSELY, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.effects.joints.geometric_error import ANGLE, LENGTH, GeometricError
from expdesign.chain.recordings.recordings import DEFLECTIONS, LoadedPoints
from expdesign.mechanics.robots.kinematic_tree import FRAME_AXES
from expdesign.mechanics.robots.robot import Robot


class Moved(StrEnum):
    """What is not where it should be: a joint's zero, or the frame at the far end of a link."""

    OFFSET = "offset"
    FRAME = "frame"


class ArmGeometry(Effect):
    """`joint k`: offset of its zero. `link k`: true minus nominal frame at its far end, in that frame (m, rad)."""

    physics = "joint_position_error"
    declared = GeometricError.declared
    measurands = (DEFLECTIONS,)
    forms = tuple(Moved)
    changes_geometry = True

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [*each_joint(robot), *each_link(robot)]

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        moved = {Part.JOINT: Moved.OFFSET, Part.LINK: Moved.FRAME}
        return [(component, moved[component.part]) for component in cls.components(robot)]

    def describe(self) -> tuple[Parameter, ...]:
        if self.component.part is Part.LINK:
            units = [
                ("m", 0.1, LOOSELY * LENGTH) if len(axis) == 1 else ("rad", 0.5, LOOSELY * ANGLE) for axis in FRAME_AXES
            ]
            tree, link = self.robot.links.tree, self.component.number
            further = [f"{end.name}_" for end in tree.ends if end.link == link][1:]
            return tuple(
                Parameter(f"frame_{end}{axis}_{unit}", 1e-3, low=-high, high=high, spread=spread)
                for end in ("", *further)
                for axis, (unit, high, spread) in zip(FRAME_AXES, units, strict=True)
            )
        if turning(self.robot, self.actuators):
            return (Parameter("offset_rad", 1e-3, low=-0.5, high=0.5),)
        return (Parameter("offset_m", 1e-3, low=-0.5, high=0.5),)

    def geometry(self, geometry: ca.SX, theta: ca.SX) -> ca.SX:
        tree = self.robot.links.tree
        first = tree.link_frames(self.component.number)[0] if self.component.part is Part.LINK else self.component.index
        moved = ca.SX(geometry)
        for index in range(theta.shape[0]):
            moved[first + index] = moved[first + index] + theta[index]
        return moved

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        if self.component.part is Part.JOINT:
            name, v = next(iter(values.items()))
            unit = "mrad" if name == "offset_rad" else "mm"
            size = f"{1e3 * v[0]:.3g} ({1e3 * v[1]:.3g} to {1e3 * v[2]:.3g})"
            return f"The zero of {self.component} is off by {size} {unit}."
        listed = ", ".join(f"{1e3 * v[0]:.2f}" for v in values.values())
        return f"The far end of {self.component} is not where it should be: ({listed}) mm and mrad in its own frame."
