"""A payload that is not as it was assumed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..kinematics import rotation_about
from ..loads import Load
from .element import Element


@dataclass(frozen=True)
class PayloadComOffset(Element):
    """The payload's centre of mass is elsewhere, by [com_dx_m, com_dy_m, com_dz_m] (m, platform axes).

    A wrench acts at a point that is off by as much.
    """

    identifier: ClassVar[str] = "payload_com_offset"
    com_dx_m: float = 0.0
    com_dy_m: float = 0.0
    com_dz_m: float = 0.0

    def true_load(self, load: Load) -> Load:
        return load.shifted(np.array([self.com_dx_m, self.com_dy_m, self.com_dz_m]))


@dataclass(frozen=True)
class PayloadMassError(Element):
    """The payload is heavier: m_true = m (1 + relative_mass_error); a wrench is scaled alike."""

    identifier: ClassVar[str] = "payload_mass_error"
    relative_mass_error: float

    def true_load(self, load: Load) -> Load:
        return load.scaled(1.0 + self.relative_mass_error)


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
