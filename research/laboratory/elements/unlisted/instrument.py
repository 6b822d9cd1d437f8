"""Instruments that misread by laws of their own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import ClassVar

import numpy as np
import pandas as pd

from ...errors import LaboratoryError
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
    accepted: ClassVar[tuple[str, ...]] = ("instrument",)
    quadratic_per_m: Sequence[Sequence[float]]

    def misread(self, deflections: Vector, rows: pd.DataFrame) -> Vector:
        axes = min(deflections.shape[1], 3)
        matrix = np.asarray(self.quadratic_per_m, dtype=float)[:axes, :axes]
        shown = deflections.copy()
        shown[:, :axes] += deflections[:, :axes] ** 2 @ matrix.T
        return shown


@dataclass(frozen=True)
class InterpolationError(Unlisted):
    """The instrument's interpolation within a signal period is not linear: an error that repeats with the reading.

    Heydemann, Appl. Opt. 20 (1981) 3382. Each position shown is d + amplitude_m sin(2 pi d/period_m), zero at the
    reference. Accepted: instrument.
    """

    identifier: ClassVar[str] = "interpolation_error"
    accepted: ClassVar[tuple[str, ...]] = ("instrument",)
    amplitude_m: Sequence[float]
    period_m: float

    def misread(self, deflections: Vector, rows: pd.DataFrame) -> Vector:
        axes = min(deflections.shape[1], 3)
        shown = deflections.copy()
        amplitude = np.asarray(self.amplitude_m, dtype=float)[:axes]
        shown[:, :axes] += amplitude * np.sin(2 * pi * deflections[:, :axes] / self.period_m)
        return shown


@dataclass(frozen=True)
class GaugeLostMotion(Unlisted):
    """The dial gauge's gear follows the stylus only when it has taken up its play.

    Play operator on the reading of one axis, in the order of the rows of a series, relaxed at its start (hysteresis of
    dial gauges: ISO 463). Accepted: instrument. `friction_hysteresis` is no wrong name.
    """

    identifier: ClassVar[str] = "gauge_lost_motion"
    accepted: ClassVar[tuple[str, ...]] = ("instrument",)
    also: ClassVar[tuple[str, ...]] = ("friction_hysteresis",)
    play_m: float
    axis: int

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


@dataclass(frozen=True)
class Refraction(Unlisted):
    """Air layers bend the line of sight with the square of the range, as strongly as the room is warm.

    Refraction angle proportional to the vertical temperature gradient (Torge, Geodesy, sec. 5.1), lift range^2/(2 R).
    Height shown is raised by bending_per_m_K range^2 (T - T0), T0 that of the series' start, range from `instrument_m`
    (in O, horizontally) to the commanded platform. Accepted: instrument, environment. `thermal_drift` is no wrong name.
    """

    identifier: ClassVar[str] = "refraction"
    accepted: ClassVar[tuple[str, ...]] = ("instrument", "environment")
    also: ClassVar[tuple[str, ...]] = ("thermal_drift",)
    bending_per_m_K: float
    instrument_m: Sequence[float]
    up: int = 2

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
