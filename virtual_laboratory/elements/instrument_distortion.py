"""An instrument that distorts; outside the library of known effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..kinematics import Pose
from .element import Element


@dataclass(frozen=True)
class InstrumentDistortion(Element):
    """The instrument's errors grow with the square of distance; outside the library of known effects.

    With r = p - `instrument_m` (m, in O): positions are shown as p + quadratic_per_m r^2 along each axis, and
    lines of sight bend, which lifts z by refraction_per_m (r_x^2 + r_y^2) (1/m).
    """

    identifier: ClassVar[str] = "instrument_distortion"
    instrument_m: Sequence[float] = (0.0, 0.0, 0.0)
    quadratic_per_m: Sequence[float] = (0.0, 0.0, 0.0)
    refraction_per_m: float = 0.0

    def reading(self, pose: Pose) -> Pose:
        r = pose.position - np.asarray(self.instrument_m, dtype=float)
        shift = np.asarray(self.quadratic_per_m, dtype=float) * r**2
        shift[2] += self.refraction_per_m * (r[0] ** 2 + r[1] ** 2)
        return Pose(pose.position + shift, pose.rotation)
