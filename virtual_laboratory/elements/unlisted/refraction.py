"""Lines of sight that bend in warm air."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd

from ...errors import LaboratoryError
from ...kinematics import Vector
from .law import Unlisted


@dataclass(frozen=True)
class Refraction(Unlisted):
    """Air layers bend the line of sight with the square of the range, as strongly as the room is warm.

    Refraction angle proportional to the vertical temperature gradient (Torge, Geodesy, sec. 5.1), lift range^2/(2 R).
    Height shown is raised by bending_per_m_K range^2 (T - T0), T0 that of the series' start, range from `instrument_m`
    (in O, horizontally) to the commanded platform. Accepted: instrument, environment. `thermal_drift` is no wrong name.
    """

    identifier: ClassVar[str] = "refraction"
    also: ClassVar[tuple[str, ...]] = ("thermal_drift",)
    bending_per_m_K: float
    instrument_m: Sequence[float]
    up: int = 2

    @property
    def parts(self) -> tuple[str, ...]:
        return ("instrument", "environment")

    def misread(self, deflections: Vector, rows: pd.DataFrame) -> Vector:
        if "temperature_degC" not in rows:
            raise LaboratoryError("refraction: the rows need temperature_degC")
        shown = deflections.copy()
        away = [axis for axis in range(min(deflections.shape[1], 3)) if axis != self.up]
        place = rows[["x_m", "y_m", "z_m"][: max(away) + 1]].to_numpy(dtype=float)
        seen_from = np.asarray(self.instrument_m, dtype=float)
        square = ((place[:, away] - seen_from[away]) ** 2).sum(axis=1)
        temperature = rows["temperature_degC"]
        by_time = temperature.iloc[np.argsort(rows["sequence"].to_numpy())] if "sequence" in rows else temperature
        first = by_time.groupby(rows["series"]).first()
        warmer = (temperature - rows["series"].map(first)).to_numpy(dtype=float)
        shown[:, self.up] += self.bending_per_m_K * square * warmer
        return shown
