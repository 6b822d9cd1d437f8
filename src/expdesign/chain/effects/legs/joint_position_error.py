"""A joint is not where the geometry says, so that both the true pose and the lever arms differ."""

import casadi as ca

from expdesign.chain.components import each_leg
from expdesign.chain.effect import Effect, Parameter
from expdesign.recordings.recordings import LoadedPoints
from expdesign.robots.parallel import ParallelRobot
from expdesign.robots.robot import Robot


class JointPositionError(Effect):
    """True minus nominal position of a leg's `base` or `platform` joint (variant), in the frame it is fixed to."""

    physics = "joint_position_error"
    changes_geometry = True

    @classmethod
    def places(cls, robot: Robot, points: LoadedPoints) -> list[tuple[str, str]]:
        if not isinstance(robot, ParallelRobot):
            return []
        ends = ("base", "platform") if robot.coordinates.n > 2 else ("base",)
        return [(leg, end) for leg in each_leg(robot) for end in ends]

    def describe(self) -> tuple[Parameter, ...]:
        axes = "xyz"[: self.robot.coordinates.translations]
        return tuple(Parameter(f"joint_d{axis}_m", 1e-3, low=-0.1, high=0.1) for axis in axes)

    def geometry(self, geometry: ca.SX, theta: ca.SX) -> ca.SX:
        assert isinstance(self.robot, ParallelRobot)
        moved = ca.SX(geometry)
        for axis, parameter in zip("xyz", range(theta.shape[0]), strict=False):
            index = self.robot.geometry_names.index(f"{self.variant} {self.leg + 1} {axis}")
            moved[index] = moved[index] + theta[parameter]
        return moved

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        offsets = ", ".join(f"{1e3 * v[0]:.2f}" for v in values.values())
        return f"The {self.variant} joint of {self.component} lies ({offsets}) mm from its nominal position."
