"""The change of an arm's geometry under load, by its own weight as well as by the payload's (theory.md 2.3).

The joints stand in equilibrium where they are, not where they were sent: δ = c∘(τ_g(q + δ) + J(q + δ)ᵀF(q + δ)), with
and without the load. The deflection is the difference of the two poses; a payload's weight keeps its direction while
its lever turns with the tip. Two passes from δ = 0 give it to second order.
"""

import casadi as ca

from expdesign.chain.component import GEOMETRY, Component
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.effects.legs.geometric_stiffness import GeometricStiffness
from expdesign.chain.recordings.recordings import DEFLECTIONS
from expdesign.chain.row import Row
from expdesign.mechanics.robots.orientation import rotation_vector
from expdesign.mechanics.robots.robot import Robot

_PASSES = 2


class ArmGeometricStiffness(Effect):
    """`fraction` of the second-order correction: 1 is what mechanics asks for, 0 the base model."""

    physics = "geometric_stiffness"
    declared = GeometricStiffness.declared
    measurands = (DEFLECTIONS,)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [GEOMETRY] if robot.jointed else []

    def describe(self) -> tuple[Parameter, ...]:
        return (Parameter("fraction", 1.0, low=-5.0, high=5.0),)

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        reference = row.absolute - row.wrench
        before, turned_before = self._equilibrium(ca.SX.zeros(6) + reference, ca.SX(0.0), compliance, row)
        after, turned_after = self._equilibrium(reference + wrench, row.payload, compliance, row)
        whole = ca.vertcat(after - before, rotation_vector(turned_after @ turned_before.T))
        linear = row.pose_map @ (compliance * (row.forward.T @ wrench))
        return deflection + theta[0] * (whole - linear)

    def _equilibrium(self, wrench: ca.SX, payload: ca.SX, compliance: ca.SX, row: Row) -> tuple[ca.SX, ca.SX]:
        """Position and orientation of the tip in equilibrium under a wrench given at the commanded pose."""
        robot = self.robot.links
        q = ca.SX.sym("q", len(self.robot.configuration))
        forward, _, rotation = robot.jacobian_expressions(q)
        arm = rotation @ row.rotation.T @ row.lever - row.lever
        turned = wrench + ca.vertcat(ca.SX.zeros(3), payload * ca.cross(arm, wrench[:3]))
        torque = robot.own_weight_expression(q, row.gravity) + forward.T @ turned
        at = row.pose
        for _ in range(_PASSES):
            turned_joints = compliance * ca.substitute(torque, q, at)
            at = row.pose + ca.vertcat(
                turned_joints, ca.SX.zeros(len(self.robot.configuration) - len(self.robot.stiffness))
            )
        return robot.tip(at)

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        v = values["fraction"]
        share = f"{v[0]:.2f} ({v[1]:.2f} to {v[2]:.2f})"
        return f"The arm's geometry changes noticeably under load: {share} of what mechanics predicts."
