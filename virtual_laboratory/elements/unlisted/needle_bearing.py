"""A joint on needles: softer between two of them."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, pi, sin
from typing import ClassVar

import numpy as np

from ...legs import Leg, LegConditions
from ..element import require
from .law import LegPhysics


@dataclass(frozen=True)
class NeedleBearing(LegPhysics):
    """The fork of a universal joint runs on few needles, and is softer when the load falls between two of them.

    Variable compliance of rolling bearings (Sunnersjo, J. Sound Vib. 58 (1978) 363). Elongation
    N/k ratio (1 + cos(2 pi swivel/pitch_rad + phase_rad))/2, the swivel being the leg's angle from its home direction
    about the fork's axis, which lies at `fork_rad` about the leg. Accepted: the leg (a passive joint is its leg's).
    """

    identifier: ClassVar[str] = "needle_bearing"
    abscissa: ClassVar[str] = "swivel"
    ratio: float
    pitch_rad: float
    phase_rad: float = 0.0
    fork_rad: float = 0.0

    def __post_init__(self) -> None:
        require(self.pitch_rad > 0, "pitch_rad: must be positive")

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        home = conditions.home_direction
        across = np.cross(home, [0.0, 0.0, 1.0])
        across = across / np.linalg.norm(across)
        side = cos(self.fork_rad) * across + sin(self.fork_rad) * np.cross(home, across)
        swivel = atan2(float(conditions.direction @ side), float(conditions.direction @ home))
        return force * (self.curve(swivel, leg) - 1.0 / leg.stiffness)

    def curve(self, at: float, leg: Leg) -> float:
        return (1.0 + self.ratio * (1 + cos(2 * pi * at / self.pitch_rad + self.phase_rad)) / 2) / leg.stiffness
