"""The linear maps of elastostatics, for whole batches (theory.md 2.3).

All take the two Jacobians of a `Jacobians` object: J (twist) and J̌ (pose). The deflection is bilinear in the
compliances and the load, A(ΔF)·c = D(c)·ΔF.
"""

from expdesign.arrays import FloatArray
from expdesign.mechanics.differentiation import product_transposed
from expdesign.mechanics.robots.robot import Jacobians, invert


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
