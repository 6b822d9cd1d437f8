"""The payload's mass, or the scale of the wrench, is not as assumed.

An error that is the same fraction of every load is a change of scale of all compliances, which no deflection can tell
from soft legs (theory.md 5.2). What can be seen is one weight that is wrong among others, a mass that was forgotten (an
adapter plate) in all of them, and one disc of a stack that is wrong in every load that contains it.
"""

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.recordings.recordings import LoadedPoints
from expdesign.robots.body import Body
from expdesign.robots.robot import Robot

_RELATIVE_WIDTH = 0.02
"""Loads within this fraction of each other count as the same weight."""
_MOST_WEIGHTS = 12
_SMALLEST = 1e-9
"""N; less is no load."""


class PayloadMassError(Effect):
    """Variants: `N newton`: the load of that size is wrong by a fraction; `forgotten`: a constant is added to all;
    `N newton and more`: a constant is added to these, as the discs of a stack are put on one by one.
    """

    physics = "payload_mass_error"

    @classmethod
    def places(cls, robot: Robot, points: LoadedPoints) -> list[tuple[str, str]]:
        if np.any(points.absolute != points.wrenches):
            return []  # changes of a load are no weights
        if isinstance(robot, Body) and points.payload is None:
            return []  # what acts on a body without payload columns is what a force plate read, nothing was weighed
        sizes = _sizes(np.linalg.norm(points.wrenches[:, : robot.coordinates.translations], axis=1))
        if len(sizes) < 2:
            return []
        places = [("payload", "forgotten")]
        if len(sizes) <= _MOST_WEIGHTS:
            places += [("payload", f"{size:.6g} newton") for size in sizes]
            # From the smallest on it is what was forgotten, and the largest alone is one weight.
            places += [("payload", f"{size:.6g} newton and more") for size in sizes[1:-1]]
        return places

    def describe(self) -> tuple[Parameter, ...]:
        if self.variant == "forgotten":
            return (Parameter("forgotten_N", 1.0, low=-1e5, high=1e5),)
        if self.variant.endswith("more"):
            return (Parameter("disc_error_N", 1.0, low=-1e5, high=1e5),)
        return (Parameter("relative_mass_error", 0.01, low=-0.9, high=9.0),)

    @property
    def size(self) -> float:
        """The least load concerned, N."""
        return 0.0 if self.variant == "forgotten" else float(self.variant.split()[0])

    def load(self, wrench: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        force = ca.norm_2(row.wrench[: self.robot.coordinates.translations])
        if self.variant.endswith("newton"):
            concerned = ca.logic_and(force > self.size * (1.0 - 1e-5), force < self.size * (1.0 + _RELATIVE_WIDTH))
            return wrench * (1.0 + ca.if_else(concerned, theta[0], 0.0))
        concerned = force > max(self.size * (1.0 - 1e-5), _SMALLEST)
        return wrench * (1.0 + ca.if_else(concerned, theta[0] / ca.fmax(force, _SMALLEST), 0.0))

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        value = next(iter(values.values()))
        if self.variant == "forgotten":
            return f"Every load is {value[0]:+.3g} N ({value[1]:+.3g} to {value[2]:+.3g}) off, as by a forgotten part."
        if self.variant.endswith("more"):
            return (
                f"Every load of {self.size:.4g} N and more is {value[0]:+.3g} N ({value[1]:+.3g} to {value[2]:+.3g}) "
                "off, as by one disc of a stack."
            )
        return (
            f"The load of {self.size:.4g} N ({self.size / 9.80665:.4g} kg of weight) is really {100 * value[0]:+.2f} % "
            f"({100 * value[1]:+.2f} to {100 * value[2]:+.2f} %) of that heavier."
        )


def _sizes(forces: FloatArray) -> list[float]:
    """The least of each group of loads of one size, rising."""
    sizes: list[float] = []
    for value in np.sort(forces[forces > _SMALLEST]):
        if not sizes or value > sizes[-1] * (1.0 + _RELATIVE_WIDTH):
            sizes.append(float(value))
    return sizes
