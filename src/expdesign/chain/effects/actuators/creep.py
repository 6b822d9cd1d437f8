"""Creep: the deflection grows with time under constant load (a Kelvin-Voigt element in series with a leg's spring)."""

from collections.abc import Sequence

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import Component, actuators_and_all
from expdesign.chain.declaration import Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


class Creep(Effect):
    """Δq gains s with τ_c·ds/dt = ratio·c·τ − s; per leg the states are s and the force of the row before.

    The load of a row was applied somewhere between the row before and itself: at the fraction `applied` of the
    interval, which is fitted.
    """

    physics = "creep"
    declared = Declaration(
        left_out="growth under constant load",
        phrase="creep of {component}",
        usually="plastics, rubber, adhesive and grease",
        port="actuators",
        inputs=(Input.FORCE, Input.HISTORY),
        sizes=(Size("creep_ratio", 0.02, "assumed: greased rolling contacts, 2 % within the time of a series"),),
    )

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return actuators_and_all(robot)

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> Sequence[tuple[Component, Variant]]:
        return super().shown(robot, points) if points.time is not None else []

    def describe(self) -> tuple[Parameter, ...]:
        self.states = 2 * len(self.actuators)
        return (
            Parameter("creep_ratio", 0.1, low=-0.9, high=10.0),
            Parameter("tau_s", 100.0, neutral=100.0, low=1e-2, high=1e7, shape=True),
            Parameter("applied", 0.5, neutral=0.0, low=0.0, high=1.0, shape=True),
        )

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        assert points.time is not None
        intervals = np.diff(points.time)
        intervals = intervals[intervals > 0.0]
        if intervals.size == 0:
            return [self.neutral()]
        shortest = float(np.median(intervals)) / 3.0
        longest = max(
            3.0 * max(float(np.ptp(points.time[points.series == s])) for s in np.unique(points.series)), 3.0 * shortest
        )
        times = np.geomspace(shortest, longest, 6)
        return [np.array([0.0, tau, applied]) for tau in times for applied in (0.0, 1.0)]

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        ratio, tau, applied = theta[0], theta[1], theta[2]
        count = len(self.actuators)
        before_load = 1.0 - ca.exp(-applied * row.interval / tau)
        under_load = 1.0 - ca.exp(-(1.0 - applied) * row.interval / tau)
        gained = ca.SX.zeros(elongation.shape[0])
        following = ca.SX.zeros(state.shape[0])
        for index, leg in enumerate(self.actuators):
            crept, previous = state[index], state[count + index]
            crept = crept + (compliance[leg] * previous - crept) * before_load
            crept = crept + (compliance[leg] * force[leg] - crept) * under_load
            following[index] = crept
            following[count + index] = force[leg]
            gained[leg] = ratio * crept
        return elongation + gained, following

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        ratio, tau = values["creep_ratio"], values["tau_s"]
        return (
            f"Under constant load {self.component} creep{'' if self.component.several else 's'} by a further "
            f"{100 * ratio[0]:.1f} % ({100 * ratio[1]:.1f} to {100 * ratio[2]:.1f} %), time constant {tau[0]:.3g} s."
        )
