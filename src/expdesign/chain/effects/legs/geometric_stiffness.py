"""The change of geometry under load: the conservative stiffness mapping, and more (theory.md 2.3, plant P2).

The loaded pose satisfies q(X + ΔX) = q(X) + Δq with the actuator forces of the loaded pose. One Newton step from the
linear deflection gives it to second order: the maps are taken at the loaded pose, and a payload's weight keeps its
direction while its lever turns with the platform.
"""

from enum import StrEnum

import casadi as ca

from expdesign.chain.component import GEOMETRY, Component, turned_lever
from expdesign.chain.declaration import Declaration, Input, Size
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.mechanics.elastostatics.maps import geometric_stiffness_expression
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.robots.robot import Robot


class Correction(StrEnum):
    """How far the loaded pose is followed."""

    EQUILIBRIUM = ""
    MAPPING = "mapping"


class GeometricStiffness(Effect):
    """`fraction` of the second-order correction: 1 is what mechanics asks for, 0 the base model.

    Variants: empty (the equilibrium of the loaded pose) and `mapping` (ΔX = (K_C + K_G)⁻¹·F with K_G at the unloaded
    pose for the forces of the load: the tangent of that equilibrium, not its secant, and with the load's lever fixed).
    """

    physics = "geometric_stiffness"
    declared = Declaration(
        left_out="change of the geometry under load",
        phrase="the change of geometry under load",
        usually="large deflections",
        port="geometry",
        inputs=(Input.FORCE, Input.PLACE),
        sizes=(Size("fraction", 1.0, "mechanics itself: the whole of the conservative term"),),
    )
    forms = tuple(Correction)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [GEOMETRY] if robot.on_legs else []

    def describe(self) -> tuple[Parameter, ...]:
        return (Parameter("fraction", 1.0, low=-5.0, high=5.0),)

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        robot = self.robot.inverse_kinematics
        assert robot is not None
        geometry = ca.SX(robot.geometry)
        symbol = ca.SX.sym("loaded", self.robot.coordinates.n)
        if self.variant is Correction.MAPPING:
            return self._mapped(robot, deflection, wrench, compliance, row, theta)
        lengths = robot.actuator_lengths(symbol, geometry)
        lever = row.forward.T  # actuator force per wrench at the unloaded pose
        loaded_lever = (ca.jacobian(lengths, symbol) @ robot.pose_rate_map(symbol)).T
        loaded = row.pose + deflection
        whole = row.absolute + (wrench - row.wrench)
        whole = whole + turned_lever(robot.rotation(loaded), row, wrench)
        force = ca.solve(ca.substitute(loaded_lever, symbol, loaded), whole)
        change = force - lever @ (row.absolute + (wrench - row.wrench))
        stretch = robot.actuator_lengths(loaded, geometry) - robot.actuator_lengths(row.pose, geometry)
        linear = ca.solve(row.pose_map, deflection)
        return deflection + theta[0] * (row.pose_map @ (linear - stretch + compliance * change))

    def _mapped(
        self,
        robot: ParallelRobot,
        deflection: ca.SX,
        wrench: ca.SX,
        compliance: ca.SX,
        row: Row,
        theta: ca.SX,
    ) -> ca.SX:
        """(K_C + K_G)⁻¹·K_C·ΔX, K_G = ∂(J⁻ᵀ·τ)/∂X at constant τ = Jᵀ·F (theory.md C3)."""
        forces = row.forward.T @ (row.absolute + (wrench - row.wrench))
        geometric = geometric_stiffness_expression(robot, row.pose, forces)
        softening = row.pose_map @ ca.diag(compliance) @ row.forward.T @ geometric
        eye = ca.SX.eye(self.robot.coordinates.n)
        return ca.solve(eye + theta[0] * softening, deflection)

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        v = values["fraction"]
        share = f"{v[0]:.2f} ({v[1]:.2f} to {v[2]:.2f})"
        return f"The geometry changes noticeably under load: {share} of what mechanics predicts."
