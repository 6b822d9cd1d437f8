"""An instrument whose scale is wrong."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..kinematics import Pose
from .element import Element


@dataclass(frozen=True)
class InstrumentScale(Element):
    """Positions are shown too large, by 1 + scale_x, ... along the axes of O (0 = right)."""

    identifier: ClassVar[str] = "instrument_scale"
    scale_x: float = 0.0
    scale_y: float = 0.0
    scale_z: float = 0.0

    def reading(self, pose: Pose) -> Pose:
        return Pose(pose.position * (1.0 + np.array([self.scale_x, self.scale_y, self.scale_z])), pose.rotation)
