"""A body's support creeps under the changes of load, or settles under the load that it has carried all along."""

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
from expdesign.mechanics.robots.robot import Robot

_NAMES = ("dx_m", "dy_m", "dz_m", "drx_rad", "dry_rad", "drz_rad")


class CreepCause(StrEnum):
    """What makes the support give way."""

    LOAD = ""
    SETTLING = "settling"


class SupportCreep(Effect):
    """Variants: empty: ω gains C·s with τ·ds/dt = M − s (Kelvin-Voigt, C symmetric; the load of a row acts since the
    row before); `settling`: the body gains a·(1 − exp(−t/τ)) from the start of the series, whatever the loads.
    """

    physics = "creep"
    declared = Declaration(
        left_out="growth under constant load",
        phrase="creep of {component}",
        usually="tyres, rubber feet and floors",
        port="supports",
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
