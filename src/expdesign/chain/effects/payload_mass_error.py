"""The payload's mass, or the scale of the wrench, is not as assumed.

An error that is the same fraction of every load is a change of scale of all compliances, which no deflection can tell
from soft legs (theory.md 5.2). What can be seen is one weight that is wrong among others, and a mass that was forgotten
(an adapter plate) in all of them.
"""

import casadi as ca
import numpy as np

from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.recordings.recordings import LoadedPoints
from expdesign.robots.robot import Robot

_RELATIVE_WIDTH = 0.02
"""Loads within this fraction of each other count as the same weight."""
_MOST_WEIGHTS = 6


class PayloadMassError(Effect):
    """Variants: `N newton`: the load of that size is wrong by a fraction; `forgotten`: a constant is added to all."""

    physics = "payload_mass_error"

    @classmethod
    def places(cls, robot: Robot, points: LoadedPoints) -> list[tuple[str, str]]:
        force = np.linalg.norm(points.wrenches[:, : robot.coordinates.translations], axis=1)
        sizes: list[float] = []
        for value in np.sort(force[force > 1e-9]):
            if not sizes or value > sizes[-1] * (1.0 + _RELATIVE_WIDTH):
                sizes.append(float(value))
        if not 2 <= len(sizes) <= _MOST_WEIGHTS:
            return []
        return [("payload", f"{size:.6g} newton") for size in sizes] + [("payload", "forgotten")]

    def describe(self) -> tuple[Parameter, ...]:
        if self.variant == "forgotten":
            return (Parameter("forgotten_N", 1.0, low=-1e5, high=1e5),)
        return (Parameter("relative_mass_error", 0.01, low=-0.9, high=9.0),)

    def load(self, wrench: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        force = ca.norm_2(row.wrench[: self.robot.coordinates.translations])
        if self.variant == "forgotten":
            return wrench * (1.0 + ca.if_else(force > 0.0, theta[0] / ca.fmax(force, 1e-9), 0.0))
        size = float(self.variant.split()[0])
        concerned = ca.logic_and(force > size * (1.0 - 1e-5), force < size * (1.0 + _RELATIVE_WIDTH))
        return wrench * (1.0 + ca.if_else(concerned, theta[0], 0.0))

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        if self.variant == "forgotten":
            value = values["forgotten_N"]
            return f"Every load is {value[0]:+.3g} N ({value[1]:+.3g} to {value[2]:+.3g}) off, as by a forgotten part."
        value = values["relative_mass_error"]
        size = float(self.variant.split()[0])
        return (
            f"The load of {size:.4g} N ({size / 9.80665:.4g} kg of weight) is really {100 * value[0]:+.2f} % "
            f"({100 * value[1]:+.2f} to {100 * value[2]:+.2f} %) of that heavier."
        )
