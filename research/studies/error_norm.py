"""Mean and standard deviation of the length of a planar error (theory.md 4.3, C15)."""

import numpy as np
from scipy.special import ellipe

from expdesign.arrays import FloatArray


def planar_norm_moments(covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """E‖e‖ and the standard deviation of ‖e‖ of a normal error with mean 0 in the plane.

    With eigenvalues l₁ ≥ l₂ of the covariance, E‖e‖ = √(2l₁/π)·𝓔(1 − l₂/l₁), 𝓔 the complete elliptic integral of the
    second kind by its parameter, and the variance is l₁ + l₂ − (E‖e‖)².

    Args:
        covariance: shape (..., 2, 2).

    Returns:
        two arrays of shape (...).
    """
    small, large = np.moveaxis(np.linalg.eigvalsh(covariance), -1, 0)
    mean: FloatArray = np.sqrt(2.0 * large / np.pi) * ellipe(1.0 - small / large)
    return mean, np.sqrt(small + large - mean**2)
