"""A leg with smooth hysteresis."""

from __future__ import annotations

from dataclasses import dataclass
from math import atanh, tanh
from typing import ClassVar

from ...legs import Leg, LegConditions, LegLaw
from ..element import require
from .law import LegPhysics

_STUCK, _CLOSE = 0.3, 1.0 - 1e-12  # share of the stiffness that is left when all slips; z/z0 at most


@dataclass(frozen=True)
class BoucWen(LegPhysics):
    """A joint in series with the leg micro-slips: force over elongation follows a rounded loop.

    Wen, J. Eng. Mech. Div. 102 (1976) 249, with exponent 2 and beta = gamma: the joint's stiffness is k_j = k/ratio,
    N = a k_j e + (1 - a) k_j z with a = 0.3, dz = (1 - (z/z0)^2) de while |z| grows and dz = de while it shrinks. Its
    slipping part carries `saturation_N` at most. Bolted and riveted joints do so (Ibrahim, Pettit, J. Sound Vib. 279
    (2005) 857). Accepted: the leg. `friction_hysteresis` is no wrong name.
    """

    identifier: ClassVar[str] = "bouc_wen"
    also: ClassVar[tuple[str, ...]] = ("friction_hysteresis",)
    ratio: float
    saturation_N: float

    def __post_init__(self) -> None:
        require(self.ratio >= 0, "ratio: must be >= 0")
        require(self.saturation_N > 0, "saturation_N: must be positive")

    def law(self, leg: Leg) -> LegLaw:
        return _Loop(self, leg)


@dataclass
class _Loop(LegLaw):
    physics: BoucWen
    leg: Leg
    yielded: float = 0.0  # e of the state that was reached
    slipping: float = 0.0  # force of the slipping part, (1 - a) k_j z (N)

    def start(self, conditions: LegConditions) -> None:
        self.yielded = self.slipping = 0.0

    def elongation(self, force: float, conditions: LegConditions) -> float:
        if self.physics.ratio == 0:
            return 0.0
        stuck = _STUCK * self.leg.stiffness / self.physics.ratio
        low, high = (force - self.physics.saturation_N) / stuck, (force + self.physics.saturation_N) / stuck
        for _ in range(80):  # the force grows with the elongation
            middle = (low + high) / 2
            low, high = (middle, high) if stuck * middle + self._slipped(middle) < force else (low, middle)
        return (low + high) / 2

    def accept(self, force: float, conditions: LegConditions) -> None:
        reached = self.elongation(force, conditions)
        if self.physics.ratio:
            self.yielded, self.slipping = reached, self._slipped(reached)

    def _slipped(self, yielded: float) -> float:
        """Force of the slipping part after a monotonic way to an elongation."""
        most, step = self.physics.saturation_N, yielded - self.yielded
        push, held = (1 - _STUCK) * self.leg.stiffness / self.physics.ratio * step, self.slipping
        if held * push < 0:  # back to zero in proportion
            if abs(push) <= abs(held):
                return held + push
            push, held = push + held, 0.0
        return most * tanh(atanh(min(max(held / most, -_CLOSE), _CLOSE)) + push / most)
