"""What a body stands on remembers its loads: friction, creep and settling."""

from dataclasses import replace
from typing import ClassVar

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import Component, symmetric
from expdesign.chain.declaration import Input, Size, Variant
from expdesign.chain.effect import Parameter, When
from expdesign.chain.effects.actuators.actuators import Creep, FrictionHysteresis
from expdesign.chain.effects.support.statics import entries
from expdesign.chain.memory import carried, relaxed
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.chain.support_effect import DRIVES, OBLIQUE, SupportEffect, SupportForm, driven
from expdesign.mechanics.robots.robot import Robot

_AZIMUTHS = tuple(np.linspace(0.0, np.pi, 6, endpoint=False))
_SHARES = (0.02, 0.08, 0.25)
"""Of the range of the load: friction from which a search starts."""


def _held(form: SupportForm, wrench: ca.SX, row: Row, state: ca.SX, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
    """What is behind the friction moves with the load that it carries: a play operator of the change of load."""
    amounts, friction, azimuth = form.drive.split(theta)
    load = form.drive.load(wrench, azimuth)
    follows = carried(state[0], load, friction)
    return form.drive.twist(amounts * follows), follows


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
    forms = tuple(
        SupportForm(
            name=str(drive),
            twist=_held,
            memory=1,
            parameters=drive.parameters(
                "behind", Parameter("friction_{force}", 10.0, neutral=10.0, low=0.0, high=1e6, shape=True), low=0.0
            ),
            drive=drive,
        )
        for drive in (*DRIVES, OBLIQUE)
    )
    shows = driven
    builds_on = "base_compliance"
    says = (
        "Loading and unloading of the support differ: part of it follows the load {variant.drive.where} only when that "
        "has changed by more than {friction:.3g} {force}."
    )

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        drive = self.variant.drive

        def thresholds(azimuth: tuple[float, ...]) -> list[float]:
            spread = float(np.ptp(drive.load(points.wrenches.T, *azimuth)))
            return [share * spread for share in _SHARES]

        return drive.starts(_AZIMUTHS, thresholds)


def _creeps(form: SupportForm, wrench: ca.SX, row: Row, state: ca.SX, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
    """ω gains C·s with τ·ds/dt = M − s; the load of a row acts since the row before."""
    crept = relaxed(state, wrench[3:], row.interval, theta[-1])
    return ca.vertcat(ca.SX.zeros(3), symmetric(theta[:6], 3) @ crept), crept


_TAU = Parameter("tau_s", 100.0, neutral=100.0, low=1e-2, high=1e7, shape=True)
_SAYS = "What the body stands on {how}, time constant {{tau_s:.3g}} s."
_CREEPING = SupportForm(
    twist=_creeps,
    memory=3,
    parameters=(*entries("creep", 1e-7), _TAU),
    says=_SAYS.format(how="gives way slowly after a change of load"),
)
_SETTLING = SupportForm(
    name="settling",
    parameters=(Parameter("settled_{deflection}", 1e-6), _TAU),
    says=_SAYS.format(how="settles from the start of the series on"),
)


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
    forms = (_CREEPING, _SETTLING)
    when: ClassVar[When] = lambda robot, points: points.timed

    def __init__(self, robot: Robot, component: Component, variant: Variant) -> None:
        super().__init__(robot, component, variant)
        # A support that settles needs no load that changes.
        self.builds_on = "" if variant == _SETTLING else "base_compliance"

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        assert points.time is not None
        intervals = np.diff(points.time)
        shortest = float(np.median(intervals[intervals > 0.0]))
        longest = max(float(np.ptp(points.time)), 3.0 * shortest)
        free = np.zeros(len(self.parameters) - 1)
        return [np.array([*free, tau]) for tau in np.geomspace(2.0 * shortest, longest, 5)]

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        if self.variant != _SETTLING:
            return deflection
        return deflection + theta[:-1] * (1.0 - ca.exp(-row.elapsed / theta[-1]))
