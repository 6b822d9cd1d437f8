"""Geometry of an arm, as its positions show it: zeros of joints, and frames of links that are not in place.

What the pose of the instrument or the place of a marker can stand for does not show and costs nothing; what remains
loosely determined is held by how well machines are made (`spread`).
"""

from typing import ClassVar

import casadi as ca

from expdesign.chain.component import ALL_JOINTS, GEOMETRY, Component, Part, each_joint, each_link
from expdesign.chain.declaration import LOOSELY, Declaration, Input, Size
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.recordings.recordings import POSITIONS, Measurand
from expdesign.mechanics.robots.kinematic_tree import FRAME_AXES
from expdesign.mechanics.robots.robot import Robot

ANGLE, LENGTH = 2e-3, 5e-4
"""rad, m; how well joints are zeroed and links are made (standard deviation), before anything is measured."""
MADE = "assumed: zeros set by marks and castings machined to 2 mrad and 0.5 mm, not calibrated"


class GeometricError(Effect):
    """Components: `joint k` (its zero), `all joints` (all zeros), `link k` (the frame at its far end, six motions),
    `geometry` (all zeros and all links).
    """

    physics = "joint_position_error"
    declared = Declaration(
        left_out="a joint or link not where the geometry has it",
        phrase="wrong geometry at {component}",
        usually="drawings, castings and zeros set by marks",
        port="geometry",
        inputs=(Input.PLACE,),
        sizes=(
            Size("*_rad", ANGLE, MADE),
            Size("*_m", LENGTH, MADE),
        ),
    )
    measurands: ClassVar[tuple[Measurand, ...]] = (POSITIONS,)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        joints = each_joint(robot)
        return [*joints, ALL_JOINTS, *each_link(robot), GEOMETRY] if joints else []

    @property
    def _indices(self) -> list[int]:
        """Geometric errors that the component has."""
        robot = self.robot.links
        count = len(self.robot.stiffness)
        if self.component == ALL_JOINTS:
            return list(range(count))
        if self.component == GEOMETRY:
            # The base's frame (the first end of link 0) is the instrument's.
            return [*range(count), *range(robot.tree.link_frames(0)[0] + len(FRAME_AXES), robot.tree.size)]
        if self.component.part is Part.JOINT:
            return [self.component.index]
        frames = robot.tree.link_frames(self.component.number)
        return [start + axis for start in frames for axis in range(len(FRAME_AXES))]

    def describe(self) -> tuple[Parameter, ...]:
        return tuple(self._parameter(index) for index in self._indices)

    def _parameter(self, index: int) -> Parameter:
        robot = self.robot.links
        count = len(self.robot.stiffness)
        angle = self.robot.units[index] == "rad" if index < count else (index - count) % len(FRAME_AXES) >= 3
        name = f"{robot.tree.geometry_names[index].replace(' ', '_')}_{'rad' if angle else 'm'}"
        spread = LOOSELY * (ANGLE if angle else LENGTH)
        return Parameter(name, 1e-3, low=-50.0 * spread, high=50.0 * spread, spread=spread)

    def geometry(self, geometry: ca.SX, theta: ca.SX) -> ca.SX:
        changed = ca.SX(geometry)
        for position, index in enumerate(self._indices):
            changed[index] += theta[position]
        return changed

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        if len(values) == 1:
            name, (value, low, high) = next(iter(values.items()))
            unit = "mrad" if name.endswith("_rad") else "mm"
            spread = f"({1e3 * low:.3g} to {1e3 * high:.3g})"
            return f"The zero of {self.component} is off by {1e3 * value:.3g} {spread} {unit}."
        return f"The geometry differs from the robot file's: {self.component}, {len(values)} parameters."
