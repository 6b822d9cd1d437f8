"""A floor that sinks under load."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isnan, log1p
from typing import ClassVar

import numpy as np

from ...errors import LaboratoryError
from ...kinematics import Vector
from ...legs import LegConditions
from ..element import require
from .yielding import Yielding, YieldLaw


@dataclass(frozen=True)
class SinkingFloor(Yielding):
    """The floor sinks with the logarithm of time under a load and comes back likewise.

    Secondary consolidation of soil and creep of concrete and timber slabs follow log time (Terzaghi, Peck, Soil
    Mechanics in Engineering Practice). Superposition over load steps: sum dF sinking log(1 + (t - t_i)/tau) along z (a
    tilt by the moment likewise). A load comes on at the row before. Accepted: base, environment (it is the ground).
    `creep` and `base_compliance` are no wrong names.
    """

    identifier: ClassVar[str] = "sinking_floor"
    side: ClassVar[str] = "base"
    also: ClassVar[tuple[str, ...]] = ("creep", "base_compliance")
    sinking_m_per_N: float
    tilting_rad_per_Nm: float
    tau_s: float

    def __post_init__(self) -> None:
        require(self.tau_s > 0, "tau_s: must be positive")

    @property
    def parts(self) -> tuple[str, ...]:
        return ("base", "environment")

    def law(self) -> YieldLaw:
        return _Floor(self)


@dataclass
class _Floor(YieldLaw):
    physics: SinkingFloor
    time: float = 0.0
    wrench: Vector = field(default_factory=lambda: np.zeros(6))
    steps: list[tuple[float, Vector]] = field(default_factory=list)

    def start(self, conditions: LegConditions) -> None:
        if isnan(conditions.time):
            raise LaboratoryError("sinking_floor: the rows need the column time_s")
        self.time, self.wrench, self.steps = conditions.time, np.zeros(6), []

    def offset(self, wrench: Vector, conditions: LegConditions) -> Vector:
        sunk = np.zeros(6)
        for begun, step in [*self.steps, (self.time, wrench - self.wrench)]:
            sunk += step * log1p((conditions.time - begun) / self.physics.tau_s)
        soft = self.physics
        return sunk * [0, 0, soft.sinking_m_per_N, soft.tilting_rad_per_Nm, soft.tilting_rad_per_Nm, 0]

    def accept(self, wrench: Vector, conditions: LegConditions) -> None:
        self.steps.append((self.time, wrench - self.wrench))
        self.time, self.wrench = conditions.time, wrench
