"""Where accuracy under load is wanted, as arrays."""

from dataclasses import dataclass
from typing import Literal

from expdesign.arrays import FloatArray

Aggregate = Literal["mean", "max"]


@dataclass(frozen=True)
class Targets:
    """Targets t with their loads, tolerances and weights.

    Attributes:
        configurations: X_D, shape (t, n_q).
        observation: S·A_D, the error along the axes of the tolerances, shape (t, n, n_p).
        importance: 1/tolerance² of each axis (1/m², 1/rad²), 0 where the axis does not matter, shape (t, n).
        weights: of each target in the mean, shape (t,).
        translations: how many leading axes are translations.
        aggregate: over targets, weighted mean of the squares or their maximum.
        axes: S, errors along the axes of the tolerances per error of the pose coordinates, shape (t, n, n); None where
            these are the same.
    """

    configurations: FloatArray
    observation: FloatArray
    importance: FloatArray
    weights: FloatArray
    translations: int
    aggregate: Aggregate = "mean"
    axes: FloatArray | None = None
