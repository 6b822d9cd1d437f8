"""A leg's commanded length has an error that repeats with the pitch of its screw.

In deflections it is an offset of all rows of a series that depends on the leg's commanded length.
"""

from collections.abc import Sequence

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import Component, each_leg
from expdesign.chain.declaration import Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.periodic_error import amplitude_pitch_phase, with_periodic_error
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot

_FINEST_PITCH = 5e-4
"""m; finer screws are not searched for."""


class EncoderPeriodicError(Effect):
    """Δq gains amplitude·sin(2π·q/pitch + phase), fitted as a sine and a cosine."""

    physics = "encoder_periodic_error"
    declared = Declaration(
        left_out="error of a command that repeats with screw or gear",
        phrase="a periodic error of the encoder of {component}",
        usually="screws and encoders",
        port="actuators",
        inputs=(Input.PLACE,),
        sizes=(
            Size("*sine_m", 1e-6, "assumed: half of what a precision screw varies within a turn (some µm, ISO 3408-3)"),
        ),
    )

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return each_leg(robot) if set(robot.units) == {"m"} else []

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> Sequence[tuple[Component, Variant]]:
        commands = len(np.unique(points.configurations, axis=0))
        return super().shown(robot, points) if commands >= 4 else []

    def describe(self) -> tuple[Parameter, ...]:
        return (
            Parameter("sine_m", 1e-6, low=-1e-2, high=1e-2),
            Parameter("cosine_m", 1e-6, low=-1e-2, high=1e-2),
            Parameter("pitch_m", 1e-4, neutral=1e-3, low=5e-5, high=1e3, shape=True),
        )

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        """Pitches at equal steps of frequency, fine enough that none lies between two of them."""
        lengths = self.robot.actuator_coordinates(points.configurations)[:, self.component.index]
        span = float(np.ptp(lengths))
        if span <= 0.0:
            return [self.neutral()]
        step = 1.0 / (3.0 * span)
        frequencies = np.arange(0.5 / span, 1.0 / _FINEST_PITCH, step)
        return [np.array([0.0, 0.0, 1.0 / frequency]) for frequency in frequencies]

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        return with_periodic_error(elongation, row, self.component.index, theta), state

    def reported(self, theta: ca.SX) -> dict[str, ca.SX]:
        return amplitude_pitch_phase(theta, "m")

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        amplitude, pitch = values["amplitude_m"], values["pitch_m"]
        return (
            f"The length of {self.component} has an error of {1e6 * amplitude[0]:.2f} ({1e6 * amplitude[1]:.2f} to "
            f"{1e6 * amplitude[2]:.2f}) µm that repeats every {1e3 * pitch[0]:.4g} mm."
        )
