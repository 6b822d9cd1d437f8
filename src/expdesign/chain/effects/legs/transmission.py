"""The transmission of a leg: its play, the leg that its force moves besides, and the error of its screw."""

from dataclasses import dataclass
from typing import ClassVar

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import Component, each_leg, on
from expdesign.chain.declaration import STRAIN_WAVE, Declaration, Input, Size
from expdesign.chain.effect import Effect, Parameter, Values, When
from expdesign.chain.form import Acting, Form
from expdesign.chain.play import resting
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


class LegBacklash(Effect):
    """A leg has play: its length jumps by the gap where its force changes sign.

    Variants: the unloaded leg rests in the `middle` of the gap, or at its `short` or `long` end.
    """

    identifier = "legs.backlash"
    physics = "leg_backlash"
    declared = Declaration(
        left_out="play of a leg",
        linear=False,
        phrase="play in {component}",
        usually="worn nuts and spherical joints",
        port="actuators",
        form="gap",
        laws=("step at zero",),
        inputs=(Input.FORCE,),
        sizes=(
            Size(
                "gap_m",
                1.5e-6,
                "V. J. Kalas, PhD thesis, Montpellier 2020 (HAL tel-03154741): hexapod repeatability ±0.75 µm; "
                "a gap is no wider",
            ),
            Size("gap_rad", 3e-4, STRAIN_WAVE),
        ),
    )
    at = each_leg
    forms = resting("short", "long")
    quantities = (Parameter("gap_{motion}", 1e-6, low=0.0, high=1e-2),)
    says = "{subject} has {gap:1e6 .3g} µ{motion} of play."


@dataclass(frozen=True)
class Partner:
    """The leg whose force also deflects this one, and whether it is so the other way round."""

    leg: Component
    shared: bool

    def __str__(self) -> str:
        return f"{'shared with' if self.shared else 'force of'} {self.leg}"


class LegCoupling(Effect):
    """The force in one leg deflects another, as through a mount that they share: Δq_j gains κ·τ_k.

    Variants: `force of leg k` (one way) and `shared with leg k` (both ways, as Maxwell and Betti have it for an elastic
    mount).
    """

    identifier = "legs.coupling"
    physics = "leg_coupling"
    declared = Declaration(
        left_out="the force in one leg deflects another",
        phrase="a force in another leg that moves {component}",
        usually="mounts that legs share",
        port="actuators",
        laws=("bracket",),
        inputs=(Input.FORCE,),
        sizes=(Size("coupling_*", 0.05, "assumed: mounts that two legs share", "actuator compliance"),),
    )
    at = each_leg
    quantities = (Parameter("coupling_{motion}_per_{force}", 1e-8, low=-1e-3, high=1e-3),)
    says = "The force of {variant.leg} also deflects {component}: {first:1e9 .3g} n{motion} per {force}."

    @classmethod
    def variants(cls, robot: Robot) -> list[Partner]:
        return [Partner(leg, shared) for shared in (False, True) for leg in each_leg(robot)]

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Partner]]:
        places = ((leg, partner) for leg in each_leg(robot) for partner in cls.variants(robot))
        seen = [(leg, p) for leg, p in places if p.leg.number > leg.number or (p.leg != leg and not p.shared)]
        return sorted(seen, key=lambda place: place[1].shared)

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        leg, other = self.component.index, self.variant.leg.index
        gained = ca.SX.zeros(elongation.shape[0])
        gained[leg] = theta[0] * force[other]
        if self.variant.shared:
            gained[other] = theta[0] * force[leg]
        return elongation + gained, state


def pitch(typical: float, neutral: float, low: float, high: float) -> Parameter:
    """After which length or angle an error repeats (m or rad)."""
    return Parameter("pitch_{motion}", typical, neutral, low, high, shape=True)


def _repeats(at: Acting, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
    """A sine and a cosine of the command."""
    angle = 2.0 * ca.pi * at.place / theta[2]
    return theta[0] * ca.sin(angle) + theta[1] * ca.cos(angle), at.state


class EncoderPeriodicError(Effect):
    """A leg's commanded length has an error that repeats with the pitch of its screw.

    Δq gains amplitude·sin(2π·q/pitch + phase). In deflections it is an offset of all rows of a series that depends on
    the leg's commanded length.

    Attributes:
        amplitude: typical and largest size (m or rad).
        pitches: of actuators that move in m, and of those that turn, with the finest that is searched for.
        most_starts: pitches that are searched at the most; None for as many as lie close enough.
        noun: what of the actuator has the error.
    """

    identifier = "legs.periodic_error"
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
    forms = (Form(_repeats),)
    at = on(lambda robot: set(robot.units) == {"m"}, each_leg)
    when: ClassVar[When] = lambda robot, points: len(np.unique(points.configurations, axis=0)) >= 4
    amplitude: ClassVar[tuple[float, float]] = (1e-6, 1e-2)
    pitches: ClassVar[dict[str, tuple[Parameter, float]]] = {"m": (pitch(1e-4, 1e-3, 5e-5, 1e3), 5e-4)}
    most_starts: ClassVar[int | None] = None
    noun: ClassVar[str] = "length"

    def describe(self) -> tuple[Parameter, ...]:
        typical, largest = self.amplitude
        waves = [Parameter(f"{wave}_{{motion}}", typical, low=-largest, high=largest) for wave in ("sine", "cosine")]
        return self.described([*waves, self.pitches[self.units[1]][0]])

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        """Pitches at equal steps of frequency, fine enough that none lies between two; a joint's repeat in a turn."""
        unit = self.units[1]
        span = float(np.ptp(self.robot.actuator_coordinates(points.configurations)[:, self.component.index]))
        if span <= 0.0:
            return [self.neutral()]
        lowest = 1.0 / (2.0 * np.pi) if unit == "rad" else 0.5 / span
        frequencies = np.arange(lowest, 1.0 / self.pitches[unit][1], 1.0 / (3.0 * span))[: self.most_starts]
        return [np.array([0.0, 0.0, 1.0 / frequency]) for frequency in frequencies]

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
