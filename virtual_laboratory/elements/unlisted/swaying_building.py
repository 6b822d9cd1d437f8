"""A floor that tilts over the day."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isnan, pi, sin
from typing import ClassVar

import numpy as np

from ...errors import LaboratoryError
from ...kinematics import Vector
from ...legs import LegConditions
from ..element import require
from .yielding import Yielding, YieldLaw


@dataclass(frozen=True)
class SwayingBuilding(Yielding):
    """The floor tilts with the sun on the building, by a slow oscillation and without any load.

    Buildings bend by microradians towards the shade within hours; tilt meters of telescopes and metrology rooms show
    it. Rotation amplitude_rad sin(2 pi t/period_s + phase_rad) about an `axis` through the origin of O, less that at
    the series' start. Accepted: base, environment. `thermal_drift` is no wrong name: it follows time, not load.
    """

    identifier: ClassVar[str] = "swaying_building"
    side: ClassVar[str] = "base"
    also: ClassVar[tuple[str, ...]] = ("thermal_drift",)
    axis: Sequence[float]
    amplitude_rad: float
    period_s: float
    phase_rad: float = 0.0

    def __post_init__(self) -> None:
        require(self.period_s > 0, "period_s: must be positive")

    @property
    def parts(self) -> tuple[str, ...]:
        return ("base", "environment")

    def law(self) -> YieldLaw:
        return _Sway(self)


@dataclass
class _Sway(YieldLaw):
    physics: SwayingBuilding

    def start(self, conditions: LegConditions) -> None:
        if isnan(conditions.time):
            raise LaboratoryError("swaying_building: the rows need the column time_s")

    def offset(self, wrench: Vector, conditions: LegConditions) -> Vector:
        phase = 2 * pi * conditions.time / self.physics.period_s + self.physics.phase_rad
        return np.concatenate([np.zeros(3), self.physics.amplitude_rad * sin(phase) * np.asarray(self.physics.axis)])
