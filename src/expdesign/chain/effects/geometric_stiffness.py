"""The change of geometry under load: the conservative stiffness mapping, and more (theory.md 2.3, plant P2).

The loaded pose satisfies q(X + ΔX) = q(X) + Δq with the actuator forces of the loaded pose. One Newton step from the
linear deflection gives it to second order: the maps are taken at the loaded pose, and a payload's weight keeps its
direction while its lever turns with the platform.
"""

import casadi as ca

from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.recordings.recordings import LoadedPoints
from expdesign.robots.parallel import ParallelRobot
from expdesign.robots.robot import Robot


class GeometricStiffness(Effect):
    """`fraction` of the second-order correction: 1 is what mechanics asks for, 0 the base model."""

    physics = "geometric_stiffness"

    @classmethod
    def places(cls, robot: Robot, points: LoadedPoints) -> list[tuple[str, str]]:
        return [("geometry", "")] if isinstance(robot, ParallelRobot) else []

    def describe(self) -> tuple[Parameter, ...]:
        return (Parameter("fraction", 1.0, low=-5.0, high=5.0),)

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        robot = self.robot
        assert isinstance(robot, ParallelRobot)
        geometry = ca.SX(robot.geometry)
        symbol = ca.SX.sym("loaded", robot.coordinates.n)
        lengths = robot.actuator_lengths(symbol, geometry)
        lever = row.forward.T  # actuator force per wrench at the unloaded pose
        loaded_lever = (ca.jacobian(lengths, symbol) @ robot.pose_rate_map(symbol)).T
        loaded = row.pose + deflection
        whole = row.absolute + (wrench - row.wrench)
        if robot.coordinates.n > 2:
            turn = robot.rotation(loaded) @ row.rotation.T
            arm = turn @ row.lever - row.lever
            whole = whole + ca.vertcat(ca.SX.zeros(3), row.payload * ca.cross(arm, wrench[:3]))
        force = ca.solve(ca.substitute(loaded_lever, symbol, loaded), whole)
        change = force - lever @ (row.absolute + (wrench - row.wrench))
        stretch = robot.actuator_lengths(loaded, geometry) - robot.actuator_lengths(row.pose, geometry)
        linear = ca.solve(row.pose_map, deflection)
        return deflection + theta[0] * (row.pose_map @ (linear - stretch + compliance * change))

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        v = values["fraction"]
        share = f"{v[0]:.2f} ({v[1]:.2f} to {v[2]:.2f})"
        return f"The geometry changes noticeably under load: {share} of what mechanics predicts."
