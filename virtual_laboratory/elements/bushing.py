"""Stiffness of an elastic connection between two bodies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..kinematics import Matrix
from .element import require

if TYPE_CHECKING:
    pass


def bushing_matrix(stiffness: Sequence[float] | Matrix) -> Matrix:
    """6 x 6 stiffness from six numbers or from a matrix; positive definite."""
    array = np.asarray(stiffness, dtype=float)
    matrix = np.diag(array) if array.ndim == 1 else array
    require(matrix.shape == (6, 6), "stiffness: needs six numbers or a 6 x 6 matrix")
    require(np.allclose(matrix, matrix.T), "stiffness: must be symmetric")
    require(bool(np.linalg.eigvalsh(matrix).min() > 0), "stiffness: must be positive definite")
    return matrix
