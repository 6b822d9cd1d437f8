"""Errors of a leg's commanded length."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi, sin
from typing import ClassVar

from ..legs import Leg, LegConditions, LegLaw
from .element import Element, legs_of, require


@dataclass(frozen=True)
class EncoderPeriodicError(Element):
    """A leg is longer than commanded by amplitude_m sin(2 pi q / pitch_m + phase_rad).

    q is the commanded length (m).

    The error repeats with the screw's pitch. The reference of a series is free of it (it stands for the state
    that the command calls for), so all rows of a series, unloaded ones too, are offset by the same error. In
    the closed loop (`Laboratory.attained`) it moves the platform.
    """

    identifier: ClassVar[str] = "encoder_periodic_error"
    component: str
    amplitude_m: float
    pitch_m: float
    phase_rad: float = 0.0

    def __post_init__(self) -> None:
        require(self.pitch_m > 0, "pitch_m: must be positive")

    def leg_laws(self, legs: Sequence[Leg]) -> Mapping[int, LegLaw]:
        return {index: _Periodic(self) for index in legs_of(self.component, len(legs))}


@dataclass
class _Periodic(LegLaw):
    error: EncoderPeriodicError

    def elongation(self, force: float, conditions: LegConditions) -> float:
        if conditions.reference:
            return 0.0
        return self.error.amplitude_m * sin(2 * pi * conditions.length / self.error.pitch_m + self.error.phase_rad)
