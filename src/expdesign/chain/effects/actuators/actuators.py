"""Actuators that are no linear springs: they creep, stick, change their stiffness with the force, or open a joint."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import ClassVar

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import actuators_and_all
from expdesign.chain.declaration import Declaration, Input, Size
from expdesign.chain.effect import Effect, Parameter, Values, When
from expdesign.chain.form import Acting, Form
from expdesign.chain.memory import carried, relaxed
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.mechanics.robots.robot import Robot


def _creeps(at: Acting, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Δq gains s with τ_c·ds/dt = ratio·c·τ − s; the states are s/ratio and the force of the row before."""
    ratio, tau, applied = theta[0], theta[1], theta[2]
    crept, previous = at.state[0], at.state[1]
    crept = relaxed(crept, at.compliance * previous, applied * at.row.interval, tau)
    crept = relaxed(crept, at.compliance * at.force, (1.0 - applied) * at.row.interval, tau)
    return ratio * crept, ca.vertcat(crept, at.force)


class Creep(Effect):
    """Creep: the deflection grows with time under constant load (a Kelvin-Voigt element in series with a leg's spring).

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
    at = actuators_and_all
    when: ClassVar[When] = lambda robot, points: points.time is not None
    forms = (Form(_creeps, memory=2),)
    quantities = (
        Parameter("creep_ratio", 0.1, low=-0.9, high=10.0),
        Parameter("tau_s", 100.0, neutral=100.0, low=1e-2, high=1e7, shape=True),
        Parameter("applied", 0.5, neutral=0.0, low=0.0, high=1.0, shape=True),
    )
    says = (
        "Under constant load {component} creep{s} by a further {creep_ratio:100 .1f %}, time constant "
        "{tau_s.best:.3g} s."
    )

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        assert points.time is not None
        intervals = np.diff(points.time)
        intervals = intervals[intervals > 0.0]
        if intervals.size == 0:
            return [self.neutral()]
        shortest = float(np.median(intervals)) / 3.0
        lasts = max(float(np.ptp(points.time[points.series == number])) for number in np.unique(points.series))
        times = np.geomspace(shortest, 3.0 * max(lasts, shortest), 6)
        return [np.array([0.0, tau, applied]) for tau in times for applied in (0.0, 1.0)]


def _largest_force(effect: Effect, points: LoadedPoints, wrenches: FloatArray) -> float:
    """The largest force (N or N·m) of the actuators concerned under wrenches (N, n) at points."""
    forward = effect.robot.jacobians(points.configurations).forward
    forces = np.einsum("nij,ni->nj", forward, wrenches)[:, effect.actuators]
    return float(np.abs(forces).max(initial=0.0))


_SLACK = 1e-6
"""N; a force that changes by less has not changed."""
_SHARES = (0.05, 0.1, 0.2, 0.4)
"""Of the largest force: friction that holds some legs altogether looks unlike a little of it."""


def _stuck(at: Acting, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
    """The spring follows its force only when that has moved by more than F: a play operator."""
    follows = carried(at.state, at.force, theta[0])
    return at.compliance * (follows - at.force), follows


def _slipping(at: Acting, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
    """A Jenkins element, with the place of its slider in force of the spring k."""
    # All in units of force: x = k·Δq, slider at s = k·place, sticking friction ρ·(x − s).
    friction, ratio, before = theta[0], theta[1], at.state
    sticking = (at.force + ratio * before) / (1.0 + ratio)
    held = ca.fmin(ca.fmax(ratio * (sticking - before), -friction), friction)
    return -at.compliance * held, at.force - held - held / ratio


def _lagging(at: Acting, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
    """The elongation lags by F against the sense of the last change; the states are the force before, and that."""
    changed = at.force - at.state[0]
    sense = ca.if_else(ca.fabs(changed) > _SLACK, ca.sign(changed), at.state[1])
    return -at.compliance * theta[0] * sense, ca.vertcat(at.force, sense)


_FRICTION = Parameter("friction_{force}", 1.0, low=0.0, high=1e5)
_CONTACT = Parameter("contact_stiffness_ratio", 1.0, neutral=3.0, low=0.05, high=1e3, shape=True)


class FrictionHysteresis(Effect):
    """Loading and unloading differ: dry friction beside the spring of a leg or joint.

    A spring k_t that slips at the friction F acts beside the actuator's spring k (a Jenkins element, variant
    `elastic`). While it sticks the actuator is stiffer, and what it carries when the load returns is the hysteresis.
    `rigid`: the actuator does not move until its force has moved by more than F. `lag`: where friction is known by its
    loop alone, it lags behind its force by F against the sense of the last change, however small that was.
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
    at = actuators_and_all
    forms = (
        Form(_stuck, "rigid", memory=1),
        Form(_slipping, "elastic", memory=1, parameters=(_FRICTION, _CONTACT)),
        Form(_lagging, "lag", memory=2),
    )
    quantities = (_FRICTION,)
    says = "Friction of {friction:.3g} {force} in {component}: loading and unloading differ."

    def large_starts(self, points: LoadedPoints) -> list[FloatArray]:
        if self.variant.law is _lagging:
            return []  # linear in the friction
        largest = _largest_force(self, points, points.wrenches)
        return [np.array([share * largest, *self.neutral()[1:]]) for share in _SHARES if largest > 0.0]


_REFERENCE = 100.0
"""N or N·m; the parameters refer to this force, so that all forms are of one size."""
_NEWTON_STEPS = 6


_SERIES: dict[str, Callable[[ca.SX], ca.SX]] = {
    "quadratic": lambda f: f * ca.fabs(f),
    "square": lambda f: f**2,
    "cube": lambda f: f**3,
    "asymmetric": ca.fabs,
    "hertz": lambda f: ca.sign(f) * ca.exp(2.0 / 3.0 * ca.log(ca.fmax(ca.fabs(f), 1e-9))),
}


def _in_series(at: Acting, theta: ca.SX, name: str) -> tuple[ca.SX, ca.SX]:
    """What stands in series with the linear spring gives way by θ·g(τ/100)."""
    now, before = (_SERIES[name](force / _REFERENCE) for force in (at.before + at.force, at.before))
    return theta[0] * now - theta[0] * before, at.state


def _cubic(at: Acting, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
    """τ = k·(x + b·x³) in place of the linear spring, b in units of the linear elongation at the reference force."""

    def beyond(relative: ca.SX) -> ca.SX:
        # A softening spring carries no more force than at its summit, 1/√(3·|b|); there the elongation ends.
        summit = 0.95 / ca.sqrt(3.0 * ca.fmax(-theta[0], 1e-9))
        x = relative
        for _ in range(_NEWTON_STEPS):
            x = ca.fmin(ca.fmax(x, -summit), summit)
            x = x - (x + theta[0] * x**3 - relative) / ca.fmax(1.0 + 3.0 * theta[0] * x**2, 0.05)
        return ca.fmin(ca.fmax(x, -summit), summit) - relative

    change = beyond((at.before + at.force) / _REFERENCE) - beyond(at.before / _REFERENCE)
    return change * at.compliance * _REFERENCE, at.state


def _named(name: str) -> Form:
    """A law of something in series by its name."""
    size = Parameter(f"{name}_at_100{{force}}_{{motion}}", 1e-6, low=-1e-2, high=1e-2)
    return Form(partial(_in_series, name=name), name, parameters=(size,), called=name)


class LegNonlinearStiffness(Effect):
    """A leg's or joint's stiffness changes with its force: something non-linear in series, or a spring that hardens.

    `quadratic`, `square`, `cube`, `asymmetric` and `hertz`: Δq gains a·g(τ), g being τ·|τ|, τ², τ³, |τ| or
    sign(τ)·|τ|^⅔. `cubic`: the spring obeys τ = k·(x + b·x³), b > 0 hardening. Forces count from zero load, not from
    the reference state: where on its characteristic a joint works, its own links' weight decides.
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
    at = actuators_and_all
    forms = (
        *map(_named, _SERIES),
        Form(
            _cubic,
            "cubic",
            parameters=(Parameter("hardening_at_100{force}", 0.1, low=-0.3, high=1e3),),
            says="The stiffness of {component} {first:hardens|softens} with its force (cubic spring, {all:+.3g} at 100 "
            "{force}).",
            called="cubic",
        ),
    )
    says = (
        "The stiffness of {component} changes with its force ({variant}): {all:1e6 +.2f} µ{motion} beyond the linear "
        "spring at 100 {force}."
    )


_OPENINGS = (0.2, 0.4, 0.6, 0.8)
"""Of the largest force: where a search lets the joint open."""
_WIDTHS = (0.1, 0.4)
"""Friction from which it starts, of the force at which the joint opens."""


def unloaded_again(robot: Robot, points: LoadedPoints) -> bool:
    """Whether some series takes a load off again, which alone tells a loop from a curve."""
    sizes = np.linalg.norm(points.wrenches[:, :3], axis=1)
    return bool(((np.diff(sizes) < 0.0) & (np.diff(points.series) == 0)).any())


def _flag(at: Acting, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
    """In generalised play operators (Visintin, Differential Models of Hysteresis, 1994, III.2) the opening of the joint
    is kept between two curves,

        x ← min(max(x, l(τ)), u(τ)),  l(τ) = (τ − F_o)₊ − (−τ − F_c)₊,  u(τ) = (τ − F_c)₊ − (−τ − F_o)₊,

    and Δq gains ratio·c·x; the state is x less its value in the reference state.
    """
    opening = theta[1]
    closing = ca.fmax(opening - 2.0 * theta[2], 0.0)

    def kept(opened: ca.SX, total: ca.SX) -> ca.SX:
        lower = ca.fmax(total - opening, 0.0) - ca.fmax(-total - closing, 0.0)
        upper = ca.fmax(total - closing, 0.0) - ca.fmax(-total - opening, 0.0)
        return ca.fmin(ca.fmax(opened, lower), upper)

    before = kept(ca.SX(0.0), at.before)
    following = kept(before + at.state, at.before + at.force) - before
    return theta[0] * at.compliance * following, following


class SelfCentring(Effect):
    """A preloaded joint of a leg opens under load and closes later than it opened: a flag-shaped loop.

    Beside the spring stands a joint that is closed until the force exceeds F_o; beyond, it yields by a compliance of
    its own. On the way back friction 2·F_f holds it open until the force is F_c = F_o − 2·F_f, so that it always
    returns to where it was (Christopoulos, Tremblay, Kim and Lacerte, J. Struct. Eng. 134, 2008, 96).
    """

    identifier = "actuators.self_centring"
    physics = "friction_hysteresis"
    declared = replace(
        FrictionHysteresis.declared,
        linear=False,
        usually="preloaded joints that open, disc springs and wire ropes",
        form="flag",
        laws=(),
        inputs=(Input.FORCE, Input.HISTORY),
        sizes=(Size("beyond_ratio", 0.2, "assumed: a joint that opens yields a fifth as much as the leg"),),
    )
    at = actuators_and_all
    when = unloaded_again
    forms = (Form(_flag, "flag", memory=1),)
    quantities = (
        Parameter("beyond_ratio", 0.5, low=0.0, high=100.0),
        Parameter("opening_{force}", 10.0, neutral=10.0, low=0.0, high=1e6, shape=True),
        Parameter("friction_{force}", 1.0, neutral=2.0, low=0.0, high=1e5, shape=True),
    )
    says = (
        "A joint in {component} opens at {opening.best:.3g} {force} and closes at {closing.best:.3g} {force}; open, it "
        "yields {beyond_ratio:.2f} times as much as the spring."
    )

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        largest = _largest_force(self, points, points.absolute)
        if largest == 0.0:
            return [self.neutral()]
        return [np.array([0.0, share * largest, width * share * largest]) for share in _OPENINGS for width in _WIDTHS]

    def sentence(self, values: Values) -> str:
        opening, friction = (value[0] for value in list(values.values())[1:3])
        return super().sentence(values | {"closing": (max(opening - 2.0 * friction, 0.0),) * 3})
