"""Nonlinear springs of other shapes."""

from __future__ import annotations

from dataclasses import dataclass
from math import copysign, exp, log, log1p, sqrt
from typing import ClassVar

from ...legs import Leg, LegConditions
from ..element import require
from ..unlisted.law import LegPhysics

SHAPES = ("preload_loss", "smeared_bilinear", "exponential", "root")


@dataclass(frozen=True)
class OtherSpring(LegPhysics):
    """A leg's stiffness changes with its force by a shape that is neither cubic nor Hertz nor two straight lines.

    Elongations beyond N/k, each times size/k and with F = scale_N: `preload_loss` sign(N) max(|N| - F, 0) (a preloaded
    nut that separates; ISO 3408-4), `smeared_bilinear` the softer side of tension and compression with a rounded
    transition F log(1 + exp(N/F)) - F log 2, `exponential` F (1 - exp(-|N|/F)) sign(N) (a foam or gasket that
    hardens), `root` F sign(N) (sqrt(1 + |N|/F) - 1) (rough surfaces pressed together). Accepted: the leg; its name is
    `leg_nonlinear_stiffness`.
    """

    identifier: ClassVar[str] = "other_spring"
    also: ClassVar[tuple[str, ...]] = ("leg_nonlinear_stiffness",)
    abscissa: ClassVar[str] = "force"
    shape: str
    size: float
    scale_N: float

    def __post_init__(self) -> None:
        require(self.shape in SHAPES, f"shape: must be one of {', '.join(SHAPES)}, not {self.shape!r}")
        require(self.scale_N > 0, "scale_N: must be positive")

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        return self.curve(force, leg)

    def curve(self, at: float, leg: Leg) -> float:
        x = abs(at) / self.scale_N
        if self.shape == "preload_loss":
            form = copysign(max(x - 1.0, 0.0), at)
        elif self.shape == "smeared_bilinear":
            form = log1p(exp(-x)) + (x if at > 0 else 0.0) - log(2.0)
        elif self.shape == "exponential":
            form = copysign(1.0 - exp(-x), at)
        else:
            form = copysign(sqrt(1.0 + x) - 1.0, at)
        return self.size * self.scale_N / leg.stiffness * form
