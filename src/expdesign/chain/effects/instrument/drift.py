"""An instrument that measures positions drifts: its frame shifts and turns slowly against the robot's base."""

from collections.abc import Sequence
from enum import StrEnum

import casadi as ca
import numpy as np

from expdesign.chain.component import INSTRUMENT, Component
from expdesign.chain.declaration import Beyond, Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.recordings.recordings import POSITIONS, LoadedPoints
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot

_HOUR = 3600.0


class FrameMotion(StrEnum):
    """Whether the instrument turns as well."""

    SHIFT = "shift"
    SHIFT_AND_TURN = "shift and turn"


class InstrumentDrift(Effect):
    """The reading y gains v·t + (w·t)×y, t the time since the first recorded row. Variants: `shift` and `shift and
    turn` (w, about the instrument's origin).
    """

    physics = "thermal_drift"
    declared = Declaration(
        left_out="drift of the instrument's frame",
        phrase="thermal drift of {component}",
        usually="tripods and stands that warm up",
        port="environment",
        inputs=(Input.TIME,),
        beyond=Beyond.HOLDS,
        sizes=(
            Size("drift_r?_rad_per_h", 1e-5, "assumed: a stand of 0.1 m that warms by 1 K on one side"),
            Size("drift_?_m_per_h", 1e-5, "assumed: a stand of 1 m of steel that warms by 1 K in an hour"),
        ),
    )
    measurands = (POSITIONS,)
    forms = tuple(FrameMotion)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [INSTRUMENT]

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> Sequence[tuple[Component, Variant]]:
        if points.time is None or not np.any(np.diff(points.time) > 0.0):
            return []
        return super().shown(robot, points)

    def describe(self) -> tuple[Parameter, ...]:
        shift = [Parameter(f"drift_{axis}_m_per_h", 1e-4) for axis in "xyz"]
        turn = [Parameter(f"drift_r{axis}_rad_per_h", 1e-5) for axis in "xyz"]
        return tuple(shift if self.variant is FrameMotion.SHIFT else shift + turn)

    def reading(self, reading: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        hours = row.clock / _HOUR
        moved = reading + theta[:3] * hours
        return moved if self.variant is FrameMotion.SHIFT else moved + ca.cross(theta[3:6] * hours, reading)

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        shift = ", ".join(f"{1e3 * values[f'drift_{axis}_m_per_h'][0]:.3g}" for axis in "xyz")
        return f"The instrument drifts against the robot's base by ({shift}) mm per hour."
