"""Play in a leg."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import copysign
from typing import ClassVar

from ..legs import Leg, LegConditions, LegLaw
from .element import Element, legs_of, require

_REST = {"middle": 0.0, "short": -0.5, "long": 0.5}


@dataclass(frozen=True)
class LegBacklash(Element):
    """A leg has play: between pulling and pushing it is free over `gap_m` (m).

    In tension the leg is longer by gap/2 than its nominal length, in compression shorter by gap/2. A leg that
    carries less than `seat_N` rests in the `middle` of its gap or at one end of it, `short` or `long`.
    """

    identifier: ClassVar[str] = "leg_backlash"
    component: str
    gap_m: float
    rest: str = "middle"
    seat_N: float = 1e-3

    def __post_init__(self) -> None:
        require(self.gap_m >= 0, "gap_m: must be >= 0")
        require(self.rest in _REST, f"rest: must be one of {', '.join(_REST)}, not {self.rest!r}")

    def leg_laws(self, legs: Sequence[Leg]) -> Mapping[int, LegLaw]:
        return {index: _Gap(self) for index in legs_of(self.component, len(legs))}


@dataclass
class _Gap(LegLaw):
    play: LegBacklash

    def elongation(self, force: float, conditions: LegConditions) -> float:
        if abs(force) < self.play.seat_N:
            return _REST[self.play.rest] * self.play.gap_m
        return copysign(self.play.gap_m / 2, force)
