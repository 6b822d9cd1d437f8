"""A leg that is softer the more it lies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...legs import Leg, LegConditions
from .law import LegPhysics


@dataclass(frozen=True)
class SaggingLeg(LegPhysics):
    """A leg that is not upright sags under its own weight, and a bowed strut is axially softer than a straight one.

    Bow and with it the loss of axial stiffness grow with the square of the weight across the leg (Ernst's modulus of
    inclined members, Der Bauingenieur 40 (1965) 52). Elongation N/k ratio (1 - (u . vertical)^2). Accepted: the leg.
    """

    identifier: ClassVar[str] = "sagging_leg"
    ratio: float
    vertical: Sequence[float] = (0.0, 0.0, 1.0)

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        upright = float(conditions.direction @ np.asarray(self.vertical, dtype=float))
        return force / leg.stiffness * self.ratio * (1.0 - upright**2)
