"""Creep: the deflection grows with time under constant load (a Kelvin-Voigt element in series with a leg's spring).

Loading and unloading differ: dry friction beside the spring of a leg or joint.

A spring k_t that slips at the friction F acts beside the leg's spring k (a Jenkins element). While it sticks the leg is
stiffer, and what it carries when the load returns is the hysteresis. With a rigid slider the leg follows its force only
when that has moved by more than F (the play operator). Where friction is known by its loop alone, the leg lags behind
its force by F against the sense of the last change, however small that was.

A leg's or joint's stiffness changes with its force: hardening, softening, Hertz contact, tension unlike compression.

A joint's characteristic counts from zero torque: where on it the joint works, its own links' weight decides.
"""

from collections.abc import Callable, Sequence
from enum import StrEnum

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import Component, actuators_and_all, reference_force, turning
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

    identifier = "actuators.creep"
    physics = "creep"
    declared = Declaration(
        left_out="growth under constant load",
        phrase="creep of {component}",
        usually="plastics, rubber, adhesive and grease",
        port="actuators",
        form="exponential",
        laws=("creep",),
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


_SLACK = 1e-6
"""N; a force that changes by less has not changed."""
_SHARES = (0.05, 0.1, 0.2, 0.4)
"""Of the largest force: friction that holds some legs altogether looks unlike a little of it."""


class Slider(StrEnum):
    """What slips beside the spring."""

    RIGID = "rigid"
    ELASTIC = "elastic"
    LAG = "lag"


class FrictionHysteresis(Effect):
    """Variants: `rigid` (state: the force that the spring carries), `elastic` (state: the place of the slider, in force
    of the leg's spring) and `lag` (states: the force of the row before, and the sense of its last change).
    """

    identifier = "actuators.friction"
    physics = "friction_hysteresis"
    declared = Declaration(
        left_out="loading and unloading differ",
        phrase="friction in {component}",
        usually="guides, seals and clamped joints",
        port="actuators",
        form="slider",
        laws=("friction",),
        inputs=(Input.FORCE, Input.PLACE, Input.HISTORY),
        sizes=(Size("friction_N*", 0.05, "assumed: a twentieth of the largest force", "actuator force"),),
    )
    forms = tuple(Slider)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return actuators_and_all(robot)

    def describe(self) -> tuple[Parameter, ...]:
        self.states = len(self.actuators) * (2 if self.variant is Slider.LAG else 1)
        friction = Parameter(
            "friction_Nm" if turning(self.robot, self.actuators) else "friction_N", 1.0, low=0.0, high=1e5
        )
        if self.variant is not Slider.ELASTIC:
            return (friction,)
        return (friction, Parameter("contact_stiffness_ratio", 1.0, neutral=3.0, low=0.05, high=1e3, shape=True))

    def large_starts(self, points: LoadedPoints) -> list[FloatArray]:
        if self.variant is Slider.LAG:
            return []  # linear in the friction
        forward = self.robot.jacobians(points.configurations).forward
        forces = np.einsum("nij,ni->nj", forward, points.wrenches)[:, self.actuators]
        sizes = [share * float(np.abs(forces).max(initial=0.0)) for share in _SHARES]
        return [np.concatenate([[size], self.neutral()[1:]]) for size in sizes if size > 0.0]

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        friction = theta[0]
        gained = ca.SX.zeros(elongation.shape[0])
        following = ca.SX.zeros(state.shape[0])
        for index, leg in enumerate(self.actuators):
            applied, before = force[leg], state[index]
            if self.variant is Slider.LAG:
                sense = state[len(self.actuators) + index]
                changed = applied - before
                sense = ca.if_else(ca.fabs(changed) > _SLACK, ca.sign(changed), sense)
                following[index], following[len(self.actuators) + index] = applied, sense
                gained[leg] = -compliance[leg] * friction * sense
                continue
            if self.variant is Slider.RIGID:
                carried = ca.fmin(ca.fmax(before, applied - friction), applied + friction)
                following[index] = carried
            else:
                # All in units of force: x = k·Δq, slider at s = k·place, sticking friction ρ·(x − s).
                ratio = theta[1]
                sticking = (applied + ratio * before) / (1.0 + ratio)
                held = ca.fmin(ca.fmax(ratio * (sticking - before), -friction), friction)
                carried = applied - held
                following[index] = carried - held / ratio
            gained[leg] = compliance[leg] * (carried - applied)
        return elongation + gained, following

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        unit = "N·m" if "friction_Nm" in values else "N"
        v = values["friction_Nm" if "friction_Nm" in values else "friction_N"]
        size = f"{v[0]:.3g} ({v[1]:.3g} to {v[2]:.3g}) {unit}"
        return f"Friction of {size} in {self.component}: loading and unloading differ."


_REFERENCE = 100.0
"""N or N·m; the parameters refer to this force, so that all forms are of one size."""
_NEWTON_STEPS = 6


class Characteristic(StrEnum):
    """What stands in series with the linear spring, or (cubic) in its place."""

    QUADRATIC = "quadratic"
    SQUARE = "square"
    CUBE = "cube"
    ASYMMETRIC = "asymmetric"
    HERTZ = "hertz"
    CUBIC = "cubic"


_SERIES: dict[Characteristic, Callable[[ca.SX], ca.SX]] = {
    Characteristic.QUADRATIC: lambda f: f * ca.fabs(f),
    Characteristic.SQUARE: lambda f: f**2,
    Characteristic.CUBE: lambda f: f**3,
    Characteristic.ASYMMETRIC: ca.fabs,
    Characteristic.HERTZ: lambda f: ca.sign(f) * ca.exp(2.0 / 3.0 * ca.log(ca.fmax(ca.fabs(f), 1e-9))),
}


class LegNonlinearStiffness(Effect):
    """Something non-linear in series with the spring, or a spring that hardens.

    `quadratic`, `square`, `cube`, `asymmetric` and `hertz`: Δq gains a·g(τ), g being τ·|τ|, τ², τ³, |τ| or
    sign(τ)·|τ|^⅔. `cubic`: the spring obeys τ = k·(x + b·x³), b > 0 hardening. Forces count from zero load, not from
    the reference state.
    """

    identifier = "actuators.nonlinear_stiffness"
    physics = "leg_nonlinear_stiffness"
    declared = Declaration(
        left_out="stiffness that depends on the force",
        linear=False,
        phrase="a spring that is not linear in {component}",
        usually="preload, rubber and rolling contacts",
        port="actuators",
        laws=("force law",),
        inputs=(Input.FORCE,),
        sizes=(
            Size("*", 0.1, "assumed: secant and tangent differ by a tenth at the targets' loads", "own deflection"),
        ),
    )
    forms = tuple(Characteristic)

    @property
    def form_name(self) -> str:
        return str(self.variant)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return actuators_and_all(robot)

    def describe(self) -> tuple[Parameter, ...]:
        force, motion = ("Nm", "rad") if turning(self.robot, self.actuators) else ("N", "m")
        if self.variant is Characteristic.CUBIC:
            # b in units of the square of the linear elongation at the reference force.
            return (Parameter(f"hardening_at_100{force}", 0.1, low=-0.3, high=1e3),)
        return (Parameter(f"{self.variant}_at_100{force}_{motion}", 1e-6, low=-1e-2, high=1e-2),)

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        before = reference_force(row)
        gained = ca.SX.zeros(elongation.shape[0])
        for leg in self.actuators:
            change = self._beyond(before[leg] + force[leg], theta[0]) - self._beyond(before[leg], theta[0])
            gained[leg] = change * (compliance[leg] * _REFERENCE if self.variant is Characteristic.CUBIC else 1.0)
        return elongation + gained, state

    def _beyond(self, force: ca.SX, parameter: ca.SX) -> ca.SX:
        """Elongation beyond the linear spring's."""
        relative = force / _REFERENCE
        if self.variant is not Characteristic.CUBIC:
            return parameter * _SERIES[self.variant](relative)
        # A softening spring carries no more force than at its summit, 1/√(3·|b|); there the elongation ends.
        summit = 0.95 / ca.sqrt(3.0 * ca.fmax(-parameter, 1e-9))
        x = relative
        for _ in range(_NEWTON_STEPS):
            x = ca.fmin(ca.fmax(x, -summit), summit)
            x = x - (x + parameter * x**3 - relative) / ca.fmax(1.0 + 3.0 * parameter * x**2, 0.05)
        return ca.fmin(ca.fmax(x, -summit), summit) - relative

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        name, (value, _, _) = next(iter(values.items()))
        at = "100 N·m" if "Nm" in name else "100 N"
        if self.variant is Characteristic.CUBIC:
            kind = "hardens" if value > 0.0 else "softens"
            return f"The stiffness of {self.component} {kind} with its force (cubic spring, {value:+.3g} at {at})."
        return (
            f"The stiffness of {self.component} changes with its force ({self.variant}): {1e6 * value:+.2f} "
            f"{'µrad' if name.endswith('rad') else 'µm'} beyond the linear spring at {at}."
        )
