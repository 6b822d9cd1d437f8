"""A controller that compensates load wrongly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...legs import Leg, LegConditions
from .law import LegPhysics


@dataclass(frozen=True)
class LoadFeedForward(LegPhysics):
    """The controller corrects for load by a gain that it takes from a wrong map of the workspace.

    Gain-scheduled feed-forward with an error that is linear in the platform's place. Elongation
    -N/k gain_per_m (travel . direction). Accepted: the leg, or for all legs `all legs` and `geometry`, since it is a
    property of the pose there.
    """

    identifier: ClassVar[str] = "load_feed_forward"
    gain_per_m: float
    direction: Sequence[float]

    @property
    def parts(self) -> tuple[str, ...]:
        return ("all legs", "geometry") if self.component == "all legs" else (self.component,)

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        away = float(conditions.travel @ np.asarray(self.direction, dtype=float))
        return -force / leg.stiffness * self.gain_per_m * away
