"""Type names for the arrays that pass between modules."""

from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.floating[Any]]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]
TextArray = npt.NDArray[np.str_]


def as_matrix(sensitivities: FloatArray) -> FloatArray:
    """Sensitivities (N, k, p) as a matrix (N·k, p), also where there are no parameters."""
    rows, readings, width = sensitivities.shape
    return sensitivities.reshape(rows * readings, width)
