"""The linear maps of elastostatics, for whole batches (theory.md 2.3).

All take the two Jacobians of a `Jacobians` object: J (twist) and J̌ (pose). The deflection is bilinear in the
compliances and the load, A(ΔF)·c = D(c)·ΔF.

Under load the legs' forces change direction as the platform moves (conservative mapping): dF = (K_C + K_G)·dX with
K_G = ∂(J⁻ᵀτ)/∂X at constant actuator forces τ. The thesis drops the term; here it is an effect
(`chain/effects/legs/geometry.py`). CasADi differentiates; the formulas per mechanism stand in the tests.
"""

import casadi as ca

from expdesign.arrays import FloatArray
from expdesign.mechanics.differentiation import product_transposed
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.robots.robot import Jacobians, invert
from expdesign.mechanics.symbolic import BatchFunction


def actuator_forces(jacobians: Jacobians, wrenches: FloatArray) -> FloatArray:
    """τ = JᵀF (thesis 1.6): forces in the actuators (N or N·m) under wrenches (..., n), shape (..., n_p)."""
    forces: FloatArray = (wrenches[..., None, :] @ jacobians.forward)[..., 0, :]
    return forces


def observation_matrix(jacobians: Jacobians, wrenches: FloatArray) -> FloatArray:
    """A = J̌·diag(JᵀΔF), with A·c = ΔX (thesis 1.17, 1.18), shape (..., n, n_p), in N and N·rad/m."""
    matrix: FloatArray = jacobians.pose * actuator_forces(jacobians, wrenches)[..., None, :]
    return matrix


def cartesian_compliance(jacobians: Jacobians, compliance: FloatArray) -> FloatArray:
    """D = J̌·diag(c)·Jᵀ = K_C⁻¹, with ΔX = D·ΔF (thesis 1.14), shape (..., n, n)."""
    matrix: FloatArray = product_transposed(jacobians.pose * compliance, jacobians.forward)
    return matrix


def cartesian_stiffness(jacobians: Jacobians, compliance: FloatArray) -> FloatArray:
    """K_C = J⁻ᵀ·K·J̌⁻¹, with ΔF = K_C·ΔX (thesis 1.15), shape (..., n, n); for robots with square Jacobians."""
    return invert(cartesian_compliance(jacobians, compliance))


def geometric_stiffness_expression(robot: ParallelRobot, pose: ca.SX, forces: ca.SX) -> ca.SX:
    """K_G(X, τ) in pose columns, n×n, at a pose; `forces` may depend on the pose, and are held constant."""
    constant = ca.SX.sym("tau", len(robot.stiffness))
    symbol = ca.SX.sym("X", robot.coordinates.n)
    lengths = robot.actuator_lengths(symbol, ca.SX(robot.geometry))
    wrench = (ca.jacobian(lengths, symbol) @ robot.pose_rate_map(symbol)).T @ constant
    stiffness = ca.substitute(ca.jacobian(wrench, symbol), constant, forces)
    return ca.substitute(stiffness, symbol, pose)


def geometric_stiffness(robot: ParallelRobot, poses: FloatArray, forces: FloatArray) -> FloatArray:
    """K_G(X, τ) in pose columns (N/m, N, N·m/m, N·m), shape (..., n, n), from poses (..., n) and τ (..., n_p)."""
    pose, force = ca.SX.sym("X", robot.coordinates.n), ca.SX.sym("tau", len(robot.stiffness))
    expression = geometric_stiffness_expression(robot, pose, force)
    (matrix,) = BatchFunction("geometric_stiffness", [pose, force], [expression])(poses, forces)
    return matrix
