"""A temperature gradient across the base."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isnan
from typing import ClassVar

import numpy as np

from ...errors import LaboratoryError
from ...legs import Leg, LegConditions, LegLaw
from .law import Unlisted


@dataclass(frozen=True)
class BaseGradient(Unlisted):
    """The sunny side of the base grows more than the other: base joints move along one direction over the day.

    Homogeneous strain with a gradient: joint i moves by strain_per_K (T - T0) times its coordinate along `direction`,
    along `direction`; T0 is that of the series' start. Its part along the leg shortens the leg (a leg that is held
    farther away). ISO 230-3 tests machines for such distortions. Accepted: base, environment, geometry.
    `thermal_drift` is no wrong name.
    """

    identifier: ClassVar[str] = "base_gradient"
    also: ClassVar[tuple[str, ...]] = ("thermal_drift",)
    strain_per_K: float
    direction: Sequence[float]
    base_m: Sequence[Sequence[float]]

    @property
    def parts(self) -> tuple[str, ...]:
        return ("base", "environment", "geometry")

    def leg_laws(self, legs: Sequence[Leg]) -> Mapping[int, LegLaw]:
        along = np.asarray(self.base_m, dtype=float) @ np.asarray(self.direction, dtype=float)
        return {leg.index: _Grown(self, float(along[leg.index])) for leg in legs}


@dataclass
class _Grown(LegLaw):
    physics: BaseGradient
    place: float
    origin: float = 0.0

    def start(self, conditions: LegConditions) -> None:
        if isnan(conditions.temperature):
            raise LaboratoryError("base_gradient: the rows need temperature_degC")
        self.origin = conditions.temperature

    def elongation(self, force: float, conditions: LegConditions) -> float:
        moved = self.physics.strain_per_K * (conditions.temperature - self.origin) * self.place
        return moved * float(conditions.direction @ np.asarray(self.physics.direction, dtype=float))
