"""What directions explain of residuals once a model has been projected out (score tests without constraints)."""

import numpy as np

from expdesign.arrays import FloatArray

_NEGLIGIBLE = 1e-4
"""Directions of which the model already explains all but this share of the length carry no information."""
_ALIKE = 3e-4
"""Singular value, in units of the largest, below which scaled directions are the same."""


def orthonormal_basis(sensitivities: FloatArray, alike: float = 1e-9) -> FloatArray:
    """Basis (M, r) of the space spanned by whitened sensitivities (M, p); `alike`: singular value that is none."""
    norms = np.linalg.norm(sensitivities, axis=0)
    scaled = sensitivities[:, norms > 0.0] / norms[norms > 0.0]
    left, values, _ = np.linalg.svd(scaled, full_matrices=False)
    basis: FloatArray = left[:, values > alike * values[:1]]
    return basis


def explained(residuals: FloatArray, basis: FloatArray, directions: FloatArray) -> tuple[float, int]:
    """Reduction of χ² by the best combination of directions, and how many of them are independent.

    Args:
        residuals: whitened, shape (M,).
        basis: orthonormal, of the model that was fitted to them, shape (M, r).
        directions: whitened, shape (M, d).
    """
    free = directions - basis @ (basis.T @ directions)
    there = np.linalg.norm(free, axis=0) > _NEGLIGIBLE * np.linalg.norm(directions, axis=0)
    if not there.any():
        return 0.0, 0
    own = orthonormal_basis(free[:, there], _ALIKE)
    return float(((own.T @ residuals) ** 2).sum()), own.shape[1]
