"""Geometric stiffness K_G: the legs' forces change direction as the platform moves (conservative mapping).

theory.md 2.3: dF = (K_C + K_G)·dX with K_G = ∂(J⁻ᵀτ)/∂X at constant actuator forces τ. The thesis drops the term; it is
an option here. CasADi differentiates; the formulas per mechanism stand in the tests.
"""

from functools import lru_cache

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.mechanics.elastostatics.maps import actuator_forces, cartesian_compliance, observation_matrix
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.robots.robot import Jacobians, invert
from expdesign.mechanics.symbolic import BatchFunction


def geometric_stiffness_expression(robot: ParallelRobot, pose: ca.SX, forces: ca.SX) -> ca.SX:
    """K_G(X, τ) in pose columns, n×n, at a pose; `forces` may depend on the pose, and are held constant."""
    constant = ca.SX.sym("tau", len(robot.stiffness))
    symbol = ca.SX.sym("X", robot.coordinates.n)
    lengths = robot.actuator_lengths(symbol, ca.SX(robot.geometry))
    wrench = (ca.jacobian(lengths, symbol) @ robot.pose_rate_map(symbol)).T @ constant
    stiffness = ca.substitute(ca.jacobian(wrench, symbol), constant, forces)
    return ca.substitute(stiffness, symbol, pose)


@lru_cache(maxsize=32)
def _geometric_stiffness_function(robot: ParallelRobot) -> BatchFunction:
    pose = ca.SX.sym("X", robot.coordinates.n)
    force = ca.SX.sym("tau", len(robot.stiffness))
    matrix = geometric_stiffness_expression(robot, pose, force)
    return BatchFunction("geometric_stiffness", [pose, force], [matrix])


def geometric_stiffness(robot: ParallelRobot, poses: FloatArray, forces: FloatArray) -> FloatArray:
    """K_G(X, τ) in pose columns (N/m, N, N·m/m, N·m), shape (..., n, n), from poses (..., n) and τ (..., n_p)."""
    (matrix,) = _geometric_stiffness_function(robot)(poses, forces)
    return matrix


def conservative_maps(
    robot: ParallelRobot,
    poses: FloatArray,
    jacobians: Jacobians,
    wrenches: FloatArray,
    observation: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Observation matrix (of the compliances, unless another is given) and Cartesian compliance with the geometric
    stiffness taken into account.

    K_G is taken at the approximate stiffness' first-order state: D' = (I + D·K_G)⁻¹·D and A' = (I + D·K_G)⁻¹·A, so
    that A'·c = D'·ΔF still holds for the approximate compliances. Any A that says how the platform moves at constant
    wrench when its actuators move gets the same factor, (K_C + K_G)⁻¹·K_C.

    Returns:
        A' of shape (..., n, n_p) and D' of shape (..., n, n).
    """
    compliance = cartesian_compliance(jacobians, robot.compliance)
    stiffness = geometric_stiffness(robot, poses, actuator_forces(jacobians, wrenches))
    softening = np.eye(robot.coordinates.n) + compliance @ stiffness
    plain = observation_matrix(jacobians, wrenches) if observation is None else observation
    softened = invert(softening)
    return softened @ plain, softened @ compliance
