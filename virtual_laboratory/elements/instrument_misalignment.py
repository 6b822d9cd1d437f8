"""An instrument whose axes are turned."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..kinematics import Pose, rotation_about
from .element import Element


@dataclass(frozen=True)
class InstrumentMisalignment(Element):
    """The instrument's axes are those of O turned by the rotation vector [rot_x_rad, rot_y_rad, rot_z_rad].

    With Q that rotation, a position p is shown as Q^T p and an orientation R as Q^T R Q (the target on the
    platform was aligned to the same axes).
    """

    identifier: ClassVar[str] = "instrument_misalignment"
    rot_x_rad: float = 0.0
    rot_y_rad: float = 0.0
    rot_z_rad: float = 0.0

    def reading(self, pose: Pose) -> Pose:
        turn = rotation_about([self.rot_x_rad, self.rot_y_rad, self.rot_z_rad])
        return Pose(turn.T @ pose.position, turn.T @ pose.rotation @ turn)
