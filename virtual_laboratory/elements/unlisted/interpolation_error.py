"""A fringe counter with an error that repeats."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import ClassVar

import numpy as np
import pandas as pd

from ...kinematics import Vector
from .law import Unlisted


@dataclass(frozen=True)
class InterpolationError(Unlisted):
    """The instrument's interpolation within a signal period is not linear: an error that repeats with the reading.

    Heydemann, Appl. Opt. 20 (1981) 3382. Each position shown is d + amplitude_m sin(2 pi d/period_m), zero at the
    reference. Accepted: instrument.
    """

    identifier: ClassVar[str] = "interpolation_error"
    amplitude_m: Sequence[float]
    period_m: float

    @property
    def parts(self) -> tuple[str, ...]:
        return ("instrument",)

    def misread(self, deflections: Vector, rows: pd.DataFrame) -> Vector:
        axes = min(deflections.shape[1], 3)
        shown = deflections.copy()
        amplitude = np.asarray(self.amplitude_m, dtype=float)[:axes]
        shown[:, :axes] += amplitude * np.sin(2 * pi * deflections[:, :axes] / self.period_m)
        return shown
