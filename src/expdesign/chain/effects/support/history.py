"""Loading and unloading of a body's support differ: part of it yields only behind a friction (a play operator).

A body's support creeps under the changes of load, or settles under the load that it has carried all along.
"""

from collections.abc import Hashable, Sequence
from enum import StrEnum

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import BASE, Component, symmetric
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

    identifier = "support.friction"
    physics = "friction_hysteresis"
    declared = Declaration(
        left_out="loading and unloading differ",
        phrase="friction in {component}",
        usually="clamped feet and guides",
        port="supports",
        form="slider",
        laws=("friction",),
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


_NAMES = ("dx_m", "dy_m", "dz_m", "drx_rad", "dry_rad", "drz_rad")


class CreepCause(StrEnum):
    """What makes the support give way."""

    LOAD = ""
    SETTLING = "settling"


class SupportCreep(Effect):
    """Variants: empty: ω gains C·s with τ·ds/dt = M − s (Kelvin-Voigt, C symmetric; the load of a row acts since the
    row before); `settling`: the body gains a·(1 − exp(−t/τ)) from the start of the series, whatever the loads.
    """

    identifier = "support.creep"
    physics = "creep"
    declared = Declaration(
        left_out="growth under constant load",
        phrase="creep of {component}",
        usually="tyres, rubber feet and floors",
        port="supports",
        form="exponential",
        laws=("creep", "settling"),
        inputs=(Input.FORCE, Input.HISTORY, Input.TIME),
        sizes=(
            Size("creep_*_per_*", 0.02, "assumed: 2 % of the machine's compliance", "pose compliance"),
            Size("settled_d*_m", 1e-5, "assumed: tyres and rubber feet give way by 10 µm"),
            Size("settled_dr*_rad", 1e-5, "assumed: tyres and rubber feet give way by 10 µrad"),
        ),
    )
    forms = tuple(CreepCause)
    builds_on = "base_compliance"

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [BASE] if robot.on_support else []

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> Sequence[tuple[Component, Variant]]:
        if points.time is None or not np.any(np.diff(points.time) > 0.0):
            return []
        return super().shown(robot, points)

    @property
    def slot(self) -> tuple[Hashable, ...]:
        return self.physics, self.component, self.variant

    def describe(self) -> tuple[Parameter, ...]:
        # A support that settles needs no load that changes.
        self.builds_on = "" if self.variant is CreepCause.SETTLING else "base_compliance"
        tau = Parameter("tau_s", 100.0, neutral=100.0, low=1e-2, high=1e7, shape=True)
        if self.variant is CreepCause.SETTLING:
            amounts = tuple(Parameter(f"settled_{name}", 1e-6) for name in _NAMES)
            return (*amounts, tau)
        self.states = 3
        axes = ("rx", "ry", "rz")
        pairs = [(a, a) for a in axes] + [(axes[i], axes[j]) for i in range(3) for j in range(i + 1, 3)]
        low = {True: 0.0, False: float("-inf")}
        return (*(Parameter(f"creep_{a}_{b}_rad_per_Nm", 1e-7, low=low[a == b]) for a, b in pairs), tau)

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        assert points.time is not None
        intervals = np.diff(points.time)
        shortest = float(np.median(intervals[intervals > 0.0]))
        longest = max(float(np.ptp(points.time)), 3.0 * shortest)
        free = np.zeros(len(self.parameters) - 1)
        return [np.array([*free, tau]) for tau in np.geomspace(2.0 * shortest, longest, 5)]

    def structure_with_memory(
        self, deflection: ca.SX, wrench: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        tau = theta[-1]
        if self.variant is CreepCause.SETTLING:
            return deflection + theta[:6] * (1.0 - ca.exp(-row.elapsed / tau)), state
        crept = state + (wrench[3:] - state) * (1.0 - ca.exp(-row.interval / tau))
        turn = symmetric(theta[:6], 3) @ crept
        return deflection + row.rates @ ca.vertcat(ca.SX.zeros(3), turn), crept

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        tau = values["tau_s"]
        time = f"time constant {tau[0]:.3g} ({tau[1]:.3g} to {tau[2]:.3g}) s"
        if self.variant is CreepCause.SETTLING:
            return f"What the body stands on settles from the start of the series on, {time}."
        return f"What the body stands on gives way slowly after a change of load, {time}."
