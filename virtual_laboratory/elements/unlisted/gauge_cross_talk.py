"""Displacement gauges that look past their axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd

from ...kinematics import Vector
from .law import Unlisted


@dataclass(frozen=True)
class GaugeCrossTalk(Unlisted):
    """Gauges read along one axis what happens on another: quadratic (cosine) errors of a lever or a round tip.

    A gauge whose stylus slides on a tilted or round face reads the square of the sideways motion (Abbe, cosine error;
    Bryan, Precision Eng. 1 (1979) 129). Each position shown is d_i + sum_j quadratic_per_m[i][j] d_j^2 of the
    deflection. Accepted: instrument.
    """

    identifier: ClassVar[str] = "gauge_cross_talk"
    quadratic_per_m: Sequence[Sequence[float]]

    @property
    def parts(self) -> tuple[str, ...]:
        return ("instrument",)

    def misread(self, deflections: Vector, rows: pd.DataFrame) -> Vector:
        axes = min(deflections.shape[1], 3)
        matrix = np.asarray(self.quadratic_per_m, dtype=float)[:axes, :axes]
        shown = deflections.copy()
        shown[:, :axes] += deflections[:, :axes] ** 2 @ matrix.T
        return shown
