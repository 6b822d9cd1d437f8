"""Effects of single actuators, the same in a leg and in a joint: what play and periodic errors are."""

from dataclasses import dataclass
from typing import ClassVar

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import Component
from expdesign.chain.declaration import ONLY, STRAIN_WAVE, Declaration, Input, Parameter, Size, Variant
from expdesign.chain.effect import Values
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.chain.tabulated import TabulatedEffect
from expdesign.mechanics.robots.robot import Robot


@dataclass(frozen=True)
class Acting:
    """One of the actuators concerned, at a row.

    Attributes:
        index: which one.
        before: its force in the reference state (N or N·m).
        force: by which the load changes that.
        compliance: c (m/N or rad/(N·m)).
        place: its commanded coordinate (m or rad).
        state: what it remembers of the row before, (`ActuatorEffect.memory`,).
    """

    index: int
    before: ca.SX
    force: ca.SX
    compliance: ca.SX
    place: ca.SX
    state: ca.SX


class ActuatorEffect(TabulatedEffect):
    """An effect that lengthens each of the actuators concerned by what that alone decides.

    Attributes:
        memory: states of one actuator.
    """

    memory: int = 0

    def __init__(self, robot: Robot, component: Component, variant: Variant = ONLY) -> None:
        super().__init__(robot, component, variant)
        self.states = self.memory * len(self.actuators) if self.memory else 0

    def largest_force(self, points: LoadedPoints, wrenches: FloatArray) -> float:
        """The largest force (N or N·m) of the actuators concerned under wrenches (N, n) at points."""
        forward = self.robot.jacobians(points.configurations).forward
        forces = np.einsum("nij,ni->nj", forward, wrenches)[:, self.actuators]
        return float(np.abs(forces).max(initial=0.0))

    def gain(self, at: Acting, row: Row, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
        """What an actuator gains (m or rad), and its next states (`memory`,)."""
        raise NotImplementedError

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        gained, following = ca.SX.zeros(elongation.shape[0]), []
        for number, index in enumerate(self.actuators):
            own = state[number * self.memory : (number + 1) * self.memory] if self.memory else ca.SX.zeros(0)
            before = row.reference_force[index]
            at = Acting(index, before, force[index], compliance[index], row.lengths[index], own)
            gained[index], after = self.gain(at, row, theta)
            following.append(after)
        return elongation + gained, ca.vertcat(*following) if self.memory else state


SLACK = 1e-3
"""N or N·m; an actuator with less force than this rests where it rested unloaded."""
_ENDS = ((0.5, -0.5), (1.0, 0.0), (0.0, -1.0))
"""Where in its gap a positive and a negative force hold an actuator, in gaps from where it rests, for each variant."""


class Backlash(ActuatorEffect):
    """Δq gains the way from where the unloaded actuator rests to the end of the gap at which its force holds it.

    Variants, in this order: it rests in the middle of the gap, at its lower and at its upper end. The reference state
    may be loaded.
    """

    says = "{subject} has {gap:1e6 .3g} µ{motion} of play."

    def gap(self, at: Acting, theta: ca.SX) -> ca.SX:
        """Size of the gap (m or rad)."""
        return theta[0]

    def gain(self, at: Acting, row: Row, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
        upper, lower = _ENDS[self.forms.index(self.variant)]

        def place(total: ca.SX) -> ca.SX:
            return ca.if_else(total > SLACK, upper, ca.if_else(total < -SLACK, lower, 0.0))

        return self.gap(at, theta) * (place(at.before + at.force) - place(at.before)), at.state


@dataclass(frozen=True)
class Pitches:
    """Lengths or angles (m or rad) after which an error may repeat.

    Attributes:
        typical: size of the parameter.
        neutral: where nothing is known.
        low, high: limits of a fit.
        finest: finer ones are not searched for.
    """

    typical: float
    neutral: float
    low: float
    high: float
    finest: float


class PeriodicError(ActuatorEffect):
    """Δq gains amplitude·sin(2π·q/pitch + phase), fitted as a sine and a cosine of the command.

    Attributes:
        amplitude: typical and largest size (m or rad).
        pitches: of actuators that move in m, and of those that turn.
        most_starts: pitches that are searched at the most; None for as many as lie close enough.
        noun: what of the actuator has the error.
    """

    physics = "encoder_periodic_error"
    declared = Declaration(
        left_out="error of a command that repeats with screw or gear",
        phrase="a periodic error of the encoder of {component}",
        usually="gears, screws and encoders",
        port="actuators",
        form="harmonic",
        laws=("periodic",),
        inputs=(Input.PLACE,),
        sizes=(
            Size("*sine_m", 1e-6, "assumed: half of what a precision screw varies within a turn (some µm, ISO 3408-3)"),
            Size("*sine_rad", 1.5e-4, STRAIN_WAVE),
        ),
    )
    amplitude: ClassVar[tuple[float, float]]
    pitches: ClassVar[dict[str, Pitches]]
    most_starts: ClassVar[int | None] = None
    noun: ClassVar[str]

    def describe(self) -> tuple[Parameter, ...]:
        (typical, largest), pitch = self.amplitude, self.pitches[self.units[1]]
        waves = [Parameter(f"{wave}_{{motion}}", typical, low=-largest, high=largest) for wave in ("sine", "cosine")]
        repeats = Parameter("pitch_{motion}", pitch.typical, pitch.neutral, pitch.low, pitch.high, shape=True)
        return self.described([*waves, repeats])

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        """Pitches at equal steps of frequency, fine enough that none lies between two; a joint's repeat in a turn."""
        unit = self.units[1]
        span = float(np.ptp(self.robot.actuator_coordinates(points.configurations)[:, self.component.index]))
        if span <= 0.0:
            return [self.neutral()]
        lowest = 1.0 / (2.0 * np.pi) if unit == "rad" else 0.5 / span
        frequencies = np.arange(lowest, 1.0 / self.pitches[unit].finest, 1.0 / (3.0 * span))[: self.most_starts]
        return [np.array([0.0, 0.0, 1.0 / frequency]) for frequency in frequencies]

    def gain(self, at: Acting, row: Row, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
        angle = 2.0 * ca.pi * at.place / theta[2]
        return theta[0] * ca.sin(angle) + theta[1] * ca.cos(angle), at.state

    def reported(self, theta: ca.SX) -> dict[str, ca.SX]:
        unit = self.units[1]
        size, phase = ca.sqrt(theta[0] ** 2 + theta[1] ** 2), ca.atan2(theta[1], theta[0])
        return {f"amplitude_{unit}": size, f"pitch_{unit}": theta[2], "phase_rad": phase}

    def sentence(self, values: Values) -> str:
        unit = self.units[1]
        pitch = values[f"pitch_{unit}"][0]
        often = f"{2.0 * np.pi / pitch:.3g} times a turn" if unit == "rad" else f"every {1e3 * pitch:.4g} mm"
        error = f"The {self.noun} of {{component}} has an error of {{amplitude:1e6 .3g}} µ{{motion}}"
        return self.said(f"{error} that repeats {often}.", values)
