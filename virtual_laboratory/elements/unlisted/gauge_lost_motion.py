"""A gauge with lost motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd

from ...kinematics import Vector
from .law import Unlisted


@dataclass(frozen=True)
class GaugeLostMotion(Unlisted):
    """The dial gauge's gear follows the stylus only when it has taken up its play.

    Play operator on the reading of one axis, in the order of the rows of a series, relaxed at its start (hysteresis of
    dial gauges: ISO 463). Accepted: instrument. `friction_hysteresis` is no wrong name.
    """

    identifier: ClassVar[str] = "gauge_lost_motion"
    also: ClassVar[tuple[str, ...]] = ("friction_hysteresis",)
    play_m: float
    axis: int

    @property
    def parts(self) -> tuple[str, ...]:
        return ("instrument",)

    def misread(self, deflections: Vector, rows: pd.DataFrame) -> Vector:
        shown = deflections.copy()
        order = np.argsort(rows["sequence"].to_numpy()) if "sequence" in rows else np.arange(len(rows))
        series = rows["series"].to_numpy()
        last: dict[float, float] = {}
        for row in order:
            value, before = float(deflections[row, self.axis]), last.get(series[row], 0.0)
            last[series[row]] = min(max(before, value - self.play_m / 2), value + self.play_m / 2)
            shown[row, self.axis] = last[series[row]]
        return shown
