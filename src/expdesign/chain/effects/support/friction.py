"""Loading and unloading of a body's support differ: part of it yields only behind a friction (a play operator)."""

from collections.abc import Hashable

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import BASE, Component
from expdesign.chain.declaration import Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.chain.support import AZIMUTHS, Drive, drive_load, drive_values, drives, twist_of, unit_of
from expdesign.mechanics.robots.robot import Robot


class SupportFriction(Effect):
    """The state follows the change of load within the friction; the body gains a compliance times the state.

    One state: the load that the part behind the friction carries, 0 at the start of a series. Variants: the direction
    of the load; `oblique` is a moment about a horizontal axis that is found, under which the body turns about x and y.
    """

    physics = "friction_hysteresis"
    declared = Declaration(
        left_out="loading and unloading differ",
        phrase="friction in {component}",
        usually="clamped feet and guides",
        port="supports",
        inputs=(Input.FORCE, Input.HISTORY),
        sizes=(Size("behind_*", 1e-7, "assumed: friction holds a tenth of what soft feet yield"),),
    )
    forms = tuple(Drive)
    builds_on = "base_compliance"
    states = 1

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [BASE] if robot.on_support else []

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        return [(BASE, drive) for drive in drives(points, oblique=True)] if robot.on_support else []

    @property
    def slot(self) -> tuple[Hashable, ...]:
        return self.physics, self.component, self.variant

    def describe(self) -> tuple[Parameter, ...]:
        force, motion = unit_of(self.variant)
        friction = Parameter(f"friction_{force}", 10.0, neutral=10.0, low=0.0, high=1e6, shape=True)
        if self.variant is Drive.OBLIQUE:
            return (
                Parameter("behind_rx_rad_per_Nm", 1e-6),
                Parameter("behind_ry_rad_per_Nm", 1e-6),
                friction,
                Parameter("azimuth_rad", 1.0, neutral=0.0, low=-10.0, high=10.0, shape=True),
            )
        return (Parameter(f"behind_{motion}_per_{force}", 1e-6, low=0.0), friction)

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        starts = []
        for azimuth in AZIMUTHS if self.variant is Drive.OBLIQUE else (0.0,):
            spread = float(np.ptp(drive_values(self.variant, points.wrenches, azimuth)))
            for share in (0.02, 0.08, 0.25):
                ending = [share * spread, azimuth] if self.variant is Drive.OBLIQUE else [share * spread]
                starts.append(np.array([*np.zeros(len(self.parameters) - len(ending)), *ending]))
        return starts

    def structure_with_memory(
        self, deflection: ca.SX, wrench: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        oblique = self.variant is Drive.OBLIQUE
        friction = theta[2] if oblique else theta[1]
        load = drive_load(self.variant, wrench, theta[3] if oblique else 0.0)
        carried = ca.fmin(ca.fmax(state[0], load - friction), load + friction)
        amounts = theta[:2] * carried if oblique else theta[0] * carried
        return deflection + row.rates @ twist_of(self.variant, amounts), carried

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        force, _ = unit_of(self.variant)
        v = values[f"friction_{force}"]
        unit = "N·m" if force == "Nm" else "N"
        where = "about an oblique axis" if self.variant is Drive.OBLIQUE else self.variant
        return (
            f"Loading and unloading of the support differ: part of it follows the load {where} only when that has "
            f"changed by more than {v[0]:.3g} ({v[1]:.3g} to {v[2]:.3g}) {unit}."
        )
