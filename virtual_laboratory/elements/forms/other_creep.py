"""Creep by other laws than the standard solid."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import exp, isnan, log1p
from typing import ClassVar

from ...errors import LaboratoryError
from ...legs import Leg, LegConditions, LegLaw
from ..element import require
from ..unlisted.law import LegPhysics

LAWS = ("stretched", "logarithmic", "power", "two_maxwell")


@dataclass(frozen=True)
class OtherCreep(LegPhysics):
    """A leg creeps by a law that a single relaxation time does not follow.

    Creep compliance ratio/k g(t/tau_s): `stretched` 1 - exp(-x^shape) (Kohlrausch, Ann. Phys. 91 (1854) 179),
    `logarithmic` log(1 + x), `power` x^shape (Andrade, shape 1/3), `two_maxwell` two elements tau and 8 tau in equal
    shares. Boltzmann's superposition over the load steps; a load comes on at the row before. Accepted: the leg; its
    name is `creep`.
    """

    identifier: ClassVar[str] = "other_creep"
    also: ClassVar[tuple[str, ...]] = ("creep",)
    kind: str
    ratio: float
    tau_s: float
    shape: float = 0.5

    def __post_init__(self) -> None:
        require(self.kind in LAWS, f"kind: must be one of {', '.join(LAWS)}, not {self.kind!r}")
        require(self.tau_s > 0, "tau_s: must be positive")

    def law(self, leg: Leg) -> LegLaw:
        return _Steps(self, leg)

    def grown(self, time: float) -> float:
        """g(t/tau), 0 at the load's beginning."""
        x = max(time, 0.0) / self.tau_s
        if self.kind == "stretched":
            return 1.0 - exp(-(x**self.shape))
        if self.kind == "logarithmic":
            return log1p(x)
        if self.kind == "power":
            return float(x**self.shape)
        return 1.0 - (exp(-x) + exp(-x / 8.0)) / 2.0


@dataclass
class _Steps(LegLaw):
    physics: OtherCreep
    leg: Leg
    time: float = 0.0
    force: float = 0.0
    steps: list[tuple[float, float]] = field(default_factory=list)

    def start(self, conditions: LegConditions) -> None:
        if isnan(conditions.time):
            raise LaboratoryError("other_creep: the rows need the column time_s")
        self.time, self.force, self.steps = conditions.time, 0.0, []

    def elongation(self, force: float, conditions: LegConditions) -> float:
        steps = [*self.steps, (self.time, force - self.force)]
        crept = sum(step * self.physics.grown(conditions.time - begun) for begun, step in steps)
        return self.physics.ratio / self.leg.stiffness * crept

    def accept(self, force: float, conditions: LegConditions) -> None:
        self.steps.append((self.time, force - self.force))
        self.time, self.force = conditions.time, force
