"""A region of poses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..kinematics import Pose, Vector

if TYPE_CHECKING:
    pass


@dataclass
class Region:
    """Poses within `radius` (m) of a position (m, pose coordinates); everywhere when the radius is None."""

    centre: Vector
    radius: float | None

    def holds(self, platform: Pose, home: Vector) -> bool:
        return self.radius is None or float(np.linalg.norm(platform.position - home - self.centre)) <= self.radius
