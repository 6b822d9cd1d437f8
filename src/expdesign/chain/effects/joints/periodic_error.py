"""A joint's transmission or encoder has an error that repeats with the joint's angle.

Once a turn for an eccentric scale, twice for an oval one, and with every tooth or wave of the gear. As for a leg,
it is an offset in deflections of all rows of a series that depends on the joint's command.
"""

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import Component, each_joint, each_leg, turning
from expdesign.chain.declaration import ONLY, STRAIN_WAVE, Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.periodic_error import amplitude_pitch_phase, with_periodic_error
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot

_FINEST = {True: 2.0 * np.pi / 60.0, False: 5e-4}
"""rad or m; finer periods are not searched for."""
_MOST_STARTS = 120


class JointPeriodicError(Effect):
    """Δq gains amplitude·sin(2π·q/pitch + phase), fitted as a sine and a cosine."""

    physics = "encoder_periodic_error"
    declared = Declaration(
        left_out="error of a command that repeats with screw or gear",
        phrase="a periodic error of the encoder of {component}",
        usually="gears, screws and encoders",
        port="actuators",
        inputs=(Input.PLACE,),
        sizes=(
            Size("*sine_m", 1e-6, "assumed: half of what a precision screw varies within a turn (some µm, ISO 3408-3)"),
            Size("*sine_rad", 1.5e-4, STRAIN_WAVE),
        ),
    )

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        rotary = set(robot.units) == {"rad"}
        return each_joint(robot) or (each_leg(robot) if rotary else [])

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        coordinates = robot.actuator_coordinates(points.configurations)
        commands = [len(np.unique(coordinates[:, i])) for i in range(len(robot.stiffness))]
        return [(joint, ONLY) for joint, count in zip(cls.components(robot), commands, strict=False) if count >= 4]

    def describe(self) -> tuple[Parameter, ...]:
        turns = turning(self.robot, self.actuators)
        unit, longest = ("rad", 4.0 * np.pi) if turns else ("m", 1e3)
        return (
            Parameter(f"sine_{unit}", 1e-5, low=-0.1, high=0.1),
            Parameter(f"cosine_{unit}", 1e-5, low=-0.1, high=0.1),
            Parameter(f"pitch_{unit}", 0.1 if turns else 1e-4, neutral=np.pi if turns else 1e-3,
                      low=0.5 * _FINEST[turns], high=longest, shape=True),
        )  # fmt: skip

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        """Periods at equal steps of frequency; a joint's errors repeat within a turn."""
        turns = turning(self.robot, self.actuators)
        span = float(np.ptp(self.robot.actuator_coordinates(points.configurations)[:, self.component.index]))
        if span <= 0.0:
            return [self.neutral()]
        lowest = 1.0 / (2.0 * np.pi) if turns else 0.5 / span
        frequencies = np.arange(lowest, 1.0 / _FINEST[turns], 1.0 / (3.0 * span))[:_MOST_STARTS]
        return [np.array([0.0, 0.0, 1.0 / frequency]) for frequency in frequencies]

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        return with_periodic_error(elongation, row, self.component.index, theta), state

    def reported(self, theta: ca.SX) -> dict[str, ca.SX]:
        return amplitude_pitch_phase(theta, self.parameters[0].name.split("_")[1])

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        turns = "amplitude_rad" in values
        size = values["amplitude_rad" if turns else "amplitude_m"]
        pitch = values["pitch_rad" if turns else "pitch_m"][0]
        often = f"{2.0 * np.pi / pitch:.3g} times a turn" if turns else f"every {1e3 * pitch:.4g} mm"
        listed = f"{1e6 * size[0]:.3g} ({1e6 * size[1]:.3g} to {1e6 * size[2]:.3g})"
        unit = "µrad" if turns else "µm"
        return f"The position of {self.component} has an error of {listed} {unit} that repeats {often}."
