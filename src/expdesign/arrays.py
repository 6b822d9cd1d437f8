"""Arrays that pass between modules: names of their types, and what every module does with them."""

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


def rms(residuals: FloatArray, counts: BoolArray | None = None) -> float:
    """Root mean square of residuals, over the rows that count (N,) or all; 1 is the noise floor of whitened ones."""
    chosen = residuals if counts is None else residuals[counts]
    return float(np.sqrt((chosen**2).mean())) if chosen.size else float("nan")
