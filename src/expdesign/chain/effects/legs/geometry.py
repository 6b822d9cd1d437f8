"""Geometry of a robot on legs: joints and lengths that are not nominal, and its change under load."""

from enum import StrEnum

import casadi as ca
import numpy as np

from expdesign.chain.component import GEOMETRY, each_leg, on, turned_lever
from expdesign.chain.declaration import Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter, Values
from expdesign.chain.form import Form
from expdesign.chain.recordings.recordings import POSES, POSITIONS
from expdesign.chain.row import Row
from expdesign.mechanics.elastostatics.maps import geometric_stiffness_expression
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.robots.robot import Robot

WIDEST = 0.02
"""m; standard deviation of joints and lengths of which nothing is known beforehand, far above what machining leaves."""
_SCALE = 1e-4


class LegEnd(StrEnum):
    """At which end of a leg."""

    BASE = "base"
    PLATFORM = "platform"


class JointPositionError(Effect):
    """A joint is not where the geometry says, so that both the true pose and the lever arms differ.

    True minus nominal position of a leg's `base` or `platform` joint (variant), in the frame it is fixed to.
    """

    identifier = "legs.joint_position_error"
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
    at = each_leg
    quantities = (Parameter("joint_d{axis}_m", 1e-3, low=-0.1, high=0.1),)
    says = "The {variant} joint of {component} lies ({all:1e3 .2f}) mm from its nominal position."

    @classmethod
    def variants(cls, robot: Robot) -> list[Variant]:
        names = robot.inverse_kinematics.geometry_names if robot.on_legs else ()
        return [end for end in LegEnd if f"{end} 1 x" in names]

    def geometry(self, geometry: ca.SX, theta: ca.SX) -> ca.SX:
        names = self.robot.inverse_kinematics.geometry_names
        moved = ca.SX(geometry)
        for axis, parameter in zip("xyz", range(theta.shape[0]), strict=False):
            index = names.index(f"{self.variant} {self.component.number} {axis}")
            moved[index] = moved[index] + theta[parameter]
        return moved


class LegGeometry(Effect):
    """Every joint's place and every leg's length, as absolute poses show them (theory.md 9.I).

    The true pose X solves q(X; g + δg) = q(X_C; g) + δl, X_C being the command: the controller computes lengths with
    the nominal geometry g, and the machine has another one. Parameters are true minus nominal joints (m) in the frame
    each is fixed to, then true minus commanded lengths (m or rad). Every geometric calibration has it in its models.
    """

    identifier = "legs.geometry"
    physics = "joint_position_error"
    declared = JointPositionError.declared
    measurands = (POSES, POSITIONS)
    changes_geometry = True

    at = on(lambda robot: robot.on_legs, GEOMETRY)

    def describe(self) -> tuple[Parameter, ...]:
        known = self.robot.geometry_std
        spread = WIDEST if known is None else known
        limit = 50.0 * spread
        joints = [f"{name.replace(' ', '_')}_m" for name in self.robot.inverse_kinematics.geometry_names]
        pairs = zip(self.robot.actuators, self.robot.units, strict=True)
        lengths = [f"{name.replace(' ', '_')}_length_{unit}" for name, unit in pairs]
        return tuple(Parameter(name, _SCALE, low=-limit, high=limit, spread=spread) for name in (*joints, *lengths))

    def geometry(self, geometry: ca.SX, theta: ca.SX) -> ca.SX:
        return geometry + theta[: geometry.shape[0]]

    def lengths(self, commanded: ca.SX, theta: ca.SX) -> ca.SX:
        return commanded + theta[-commanded.shape[0] :]

    def sentence(self, values: Values) -> str:
        errors = 1e3 * np.array([value[0] for value in values.values()])
        return (
            f"Joints and lengths of the legs differ from the robot file by {np.sqrt((errors**2).mean()):.3g} mm "
            f"(RMS of {len(errors)} parameters)."
        )


EQUILIBRIUM, MAPPING = Form(), Form(name="mapping")
"""How far the loaded pose is followed."""


class GeometricStiffness(Effect):
    """The change of geometry under load: the conservative stiffness mapping, and more (theory.md 2.3, plant P2).

    The loaded pose satisfies q(X + ΔX) = q(X) + Δq with the actuator forces of the loaded pose. One Newton step from
    the linear deflection gives it to second order: the maps are taken at the loaded pose, and a payload's weight keeps
    its direction while its lever turns with the platform. `fraction` of the correction: 1 is what mechanics asks for, 0
    the base model.

    Variants: empty (the equilibrium of the loaded pose) and `mapping` (ΔX = (K_C + K_G)⁻¹·F with K_G at the unloaded
    pose for the forces of the load: the tangent of that equilibrium, not its secant, and with the load's lever fixed).
    """

    identifier = "legs.geometric_stiffness"
    physics = "geometric_stiffness"
    declared = Declaration(
        left_out="change of the geometry under load",
        phrase="the change of geometry under load",
        usually="large deflections",
        port="geometry",
        inputs=(Input.FORCE, Input.PLACE),
        sizes=(Size("fraction", 1.0, "mechanics itself: the whole of the conservative term"),),
    )
    forms = (EQUILIBRIUM, MAPPING)

    at = on(lambda robot: robot.on_legs, GEOMETRY)
    quantities = (Parameter("fraction", 1.0, low=-5.0, high=5.0),)
    says = "The geometry changes noticeably under load: {fraction:.2f} of what mechanics predicts."

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        robot = self.robot.inverse_kinematics
        geometry = ca.SX(robot.geometry)
        symbol = ca.SX.sym("loaded", self.robot.coordinates.n)
        if self.variant == MAPPING:
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
        self, robot: ParallelRobot, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX
    ) -> ca.SX:
        """(K_C + K_G)⁻¹·K_C·ΔX, K_G = ∂(J⁻ᵀ·τ)/∂X at constant τ = Jᵀ·F (theory.md C3)."""
        forces = row.forward.T @ (row.absolute + (wrench - row.wrench))
        geometric = geometric_stiffness_expression(robot, row.pose, forces)
        softening = row.pose_map @ ca.diag(compliance) @ row.forward.T @ geometric
        eye = ca.SX.eye(self.robot.coordinates.n)
        return ca.solve(eye + theta[0] * softening, deflection)
