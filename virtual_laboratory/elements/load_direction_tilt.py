"""A load that is not along the assumed direction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..kinematics import rotation_about
from ..loads import Load
from .element import Element


@dataclass(frozen=True)
class LoadDirectionTilt(Element):
    """Gravity or the load is tilted: g_true = Ry(tilt_y_rad) Rx(tilt_x_rad) g about the axes of O.

    Force and moment of a wrench turn together.
    """

    identifier: ClassVar[str] = "load_direction_tilt"
    tilt_x_rad: float = 0.0
    tilt_y_rad: float = 0.0
    tilt_z_rad: float = 0.0  # the one angle of a bipod

    def true_load(self, load: Load) -> Load:
        about_x, about_y = rotation_about([self.tilt_x_rad, 0, 0]), rotation_about([0, self.tilt_y_rad, 0])
        return load.turned(rotation_about([0, 0, self.tilt_z_rad]) @ about_y @ about_x)
