"""What a body stands on remembers its loads: friction, creep and settling."""

from dataclasses import replace
from enum import StrEnum
from typing import ClassVar

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import BASE, Component, symmetric
from expdesign.chain.declaration import Input, Size, Variant
from expdesign.chain.effect import Parameter, Values, When
from expdesign.chain.effects.actuators.actuators import Creep, FrictionHysteresis
from expdesign.chain.effects.support.statics import AXES, entries
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.chain.support import AZIMUTHS, Drive, SupportEffect, drive_load, drive_values, drives, twist_of
from expdesign.mechanics.robots.robot import Robot


class SupportFriction(SupportEffect):
    """Loading and unloading of a body's support differ: part of it yields only behind a friction (a play operator).

    The state follows the change of load within the friction, 0 at the start of a series: the load that the part behind
    the friction carries. The body gains a compliance times the state. Variants: the direction of the load; `oblique` is
    a moment about a horizontal axis that is found, under which the body turns about x and y.
    """

    identifier = "support.friction"
    physics = "friction_hysteresis"
    declared = replace(
        FrictionHysteresis.declared,
        usually="clamped feet and guides",
        port="supports",
        inputs=(Input.FORCE, Input.HISTORY),
        sizes=(Size("behind_*", 1e-7, "assumed: friction holds a tenth of what soft feet yield"),),
    )
    forms = tuple(Drive)
    builds_on = "base_compliance"
    states = 1

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        return [(BASE, drive) for drive in drives(points, oblique=True)]

    def describe(self) -> tuple[Parameter, ...]:
        friction = Parameter("friction_{force}", 10.0, neutral=10.0, low=0.0, high=1e6, shape=True)
        return self.driven("behind", friction, low=0.0)

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        free = np.zeros(2 if self.drive is Drive.OBLIQUE else 1)
        starts = []
        for azimuth in self.shapes(AZIMUTHS):
            spread = float(np.ptp(drive_values(self.drive, points.wrenches, *azimuth)))
            starts += [np.array([*free, share * spread, *azimuth]) for share in (0.02, 0.08, 0.25)]
        return starts

    def structure_with_memory(
        self, deflection: ca.SX, wrench: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        amounts, friction, azimuth = self.split(theta)
        load = drive_load(self.drive, wrench, azimuth)
        carried = ca.fmin(ca.fmax(state[0], load - friction), load + friction)
        return deflection + row.rates @ twist_of(self.drive, amounts * carried), carried

    def sentence(self, values: Values) -> str:
        follows = f"part of it follows the load {self.where} only when that has changed by more than"
        return self.said(f"Loading and unloading of the support differ: {follows} {{friction:.3g}} {{force}}.", values)


class CreepCause(StrEnum):
    """What makes the support give way."""

    LOAD = ""
    SETTLING = "settling"


class SupportCreep(SupportEffect):
    """A body's support creeps under the changes of load, or settles under the load that it has carried all along.

    Variants: empty: ω gains C·s with τ·ds/dt = M − s (Kelvin-Voigt, C symmetric; the load of a row acts since the row
    before); `settling`: the body gains a·(1 − exp(−t/τ)) from the start of the series, whatever the loads.
    """

    identifier = "support.creep"
    physics = "creep"
    declared = replace(
        Creep.declared,
        usually="tyres, rubber feet and floors",
        port="supports",
        laws=("creep", "settling"),
        inputs=(Input.FORCE, Input.HISTORY, Input.TIME),
        sizes=(
            Size("creep_*_per_*", 0.02, "assumed: 2 % of the machine's compliance", "pose compliance"),
            Size("settled_d*_m", 1e-5, "assumed: tyres and rubber feet give way by 10 µm"),
            Size("settled_dr*_rad", 1e-5, "assumed: tyres and rubber feet give way by 10 µrad"),
        ),
    )
    forms = tuple(CreepCause)
    when: ClassVar[When] = lambda robot, points: points.timed

    @property
    def units(self) -> tuple[str, str]:
        return "Nm", "rad"

    def describe(self) -> tuple[Parameter, ...]:
        # A support that settles needs no load that changes.
        self.builds_on = "" if self.variant is CreepCause.SETTLING else "base_compliance"
        tau = Parameter("tau_s", 100.0, neutral=100.0, low=1e-2, high=1e7, shape=True)
        if self.variant is CreepCause.SETTLING:
            return (*(Parameter(f"settled_{name}", 1e-6) for name in self.robot.coordinates.deflection), tau)
        self.states = len(AXES)
        return (*entries("creep", 1e-7), tau)

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

    def sentence(self, values: Values) -> str:
        how = "gives way slowly after a change of load"
        if self.variant is CreepCause.SETTLING:
            how = "settles from the start of the series on"
        return self.said(f"What the body stands on {how}, time constant {{tau_s:.3g}} s.", values)
