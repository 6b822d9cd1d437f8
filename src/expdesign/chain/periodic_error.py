"""An error of an actuator's command that repeats, the same in a leg's screw and in a joint's gear."""

from dataclasses import dataclass
from typing import ClassVar

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import turning
from expdesign.chain.declaration import STRAIN_WAVE, Declaration, Input, Size
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row


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


class PeriodicError(Effect):
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

    @property
    def _unit(self) -> str:
        return "rad" if turning(self.robot, self.actuators) else "m"

    def describe(self) -> tuple[Parameter, ...]:
        (typical, largest), unit, pitch = self.amplitude, self._unit, self.pitches[self._unit]
        return (
            Parameter(f"sine_{unit}", typical, low=-largest, high=largest),
            Parameter(f"cosine_{unit}", typical, low=-largest, high=largest),
            Parameter(
                f"pitch_{unit}", pitch.typical, neutral=pitch.neutral, low=pitch.low, high=pitch.high, shape=True
            ),
        )

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        """Pitches at equal steps of frequency, fine enough that none lies between two; a joint's repeat in a turn."""
        unit = self._unit
        span = float(np.ptp(self.robot.actuator_coordinates(points.configurations)[:, self.component.index]))
        if span <= 0.0:
            return [self.neutral()]
        lowest = 1.0 / (2.0 * np.pi) if unit == "rad" else 0.5 / span
        frequencies = np.arange(lowest, 1.0 / self.pitches[unit].finest, 1.0 / (3.0 * span))[: self.most_starts]
        return [np.array([0.0, 0.0, 1.0 / frequency]) for frequency in frequencies]

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        index = self.component.index
        angle = 2.0 * ca.pi * row.lengths[index] / theta[2]
        gained = ca.SX.zeros(elongation.shape[0])
        gained[index] = theta[0] * ca.sin(angle) + theta[1] * ca.cos(angle)
        return elongation + gained, state

    def reported(self, theta: ca.SX) -> dict[str, ca.SX]:
        return {
            f"amplitude_{self._unit}": ca.sqrt(theta[0] ** 2 + theta[1] ** 2),
            f"pitch_{self._unit}": theta[2],
            "phase_rad": ca.atan2(theta[1], theta[0]),
        }

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        turns = self._unit == "rad"
        size, pitch = values[f"amplitude_{self._unit}"], values[f"pitch_{self._unit}"][0]
        often = f"{2.0 * np.pi / pitch:.3g} times a turn" if turns else f"every {1e3 * pitch:.4g} mm"
        listed = f"{1e6 * size[0]:.3g} ({1e6 * size[1]:.3g} to {1e6 * size[2]:.3g})"
        unit = "µrad" if turns else "µm"
        return f"The {self.noun} of {self.component} has an error of {listed} {unit} that repeats {often}."
