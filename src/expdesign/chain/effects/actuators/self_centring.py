"""A preloaded joint of a leg opens under load and closes later than it opened: a flag-shaped loop.

Beside the spring stands a joint that is closed until the force exceeds F_o; beyond, it yields by a compliance of its
own. On the way back friction 2·F_f holds it open until the force is F_c = F_o − 2·F_f, so that it always returns to
where it was (Christopoulos, Tremblay, Kim and Lacerte, J. Struct. Eng. 134, 2008, 96). In generalised play operators
(Visintin, Differential Models of Hysteresis, 1994, III.2) the opening of the joint is kept between two curves,

    x ← min(max(x, l(τ)), u(τ)),  l(τ) = (τ − F_o)₊ − (−τ − F_c)₊,  u(τ) = (τ − F_c)₊ − (−τ − F_o)₊.
"""

from collections.abc import Sequence
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

_OPENINGS = (0.2, 0.4, 0.6, 0.8)
"""Of the largest force: where a search lets the joint open."""
_WIDTHS = (0.1, 0.4)
"""Friction from which it starts, of the force at which the joint opens."""


class Loop(StrEnum):
    """Its one variant, which says the form that its physics has here."""

    FLAG = "flag"


class SelfCentring(Effect):
    """Δq gains ratio·c·x; per leg the state is x less its value in the reference state."""

    identifier = "actuators.self_centring"
    physics = "friction_hysteresis"
    declared = Declaration(
        left_out="loading and unloading differ",
        linear=False,
        phrase="friction in {component}",
        usually="preloaded joints that open, disc springs and wire ropes",
        port="actuators",
        form=Loop.FLAG,
        inputs=(Input.FORCE, Input.HISTORY),
        sizes=(Size("beyond_ratio", 0.2, "assumed: a joint that opens yields a fifth as much as the leg"),),
    )

    forms = tuple(Loop)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return actuators_and_all(robot)

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> Sequence[tuple[Component, Variant]]:
        return super().shown(robot, points) if _unloaded_again(points) else []

    def describe(self) -> tuple[Parameter, ...]:
        self.states = len(self.actuators)
        unit = "Nm" if turning(self.robot, self.actuators) else "N"
        return (
            Parameter("beyond_ratio", 0.5, low=0.0, high=100.0),
            Parameter(f"opening_{unit}", 10.0, neutral=10.0, low=0.0, high=1e6, shape=True),
            Parameter(f"friction_{unit}", 1.0, neutral=2.0, low=0.0, high=1e5, shape=True),
        )

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        forward = self.robot.jacobians(points.configurations).forward
        forces = np.einsum("nij,ni->nj", forward, points.absolute)[:, self.actuators]
        largest = float(np.abs(forces).max(initial=0.0))
        if largest == 0.0:
            return [self.neutral()]
        return [np.array([0.0, share * largest, width * share * largest]) for share in _OPENINGS for width in _WIDTHS]

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        ratio, opening = theta[0], theta[1]
        closing = ca.fmax(opening - 2.0 * theta[2], 0.0)
        gained, following = ca.SX.zeros(elongation.shape[0]), ca.SX.zeros(state.shape[0])

        def kept(opened: ca.SX, total: ca.SX) -> ca.SX:
            lower = ca.fmax(total - opening, 0.0) - ca.fmax(-total - closing, 0.0)
            upper = ca.fmax(total - closing, 0.0) - ca.fmax(-total - opening, 0.0)
            return ca.fmin(ca.fmax(opened, lower), upper)

        reference = reference_force(row)
        for index, leg in enumerate(self.actuators):
            before = kept(ca.SX(0.0), reference[leg])
            following[index] = kept(before + state[index], reference[leg] + force[leg]) - before
            gained[leg] = ratio * compliance[leg] * following[index]
        return elongation + gained, following

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        unit = "N·m" if "opening_Nm" in values else "N"
        opening, friction = (values[f"{name}_{unit.replace('·', '')}"][0] for name in ("opening", "friction"))
        ratio = values["beyond_ratio"]
        closing = max(opening - 2.0 * friction, 0.0)
        return (
            f"A joint in {self.component} opens at {opening:.3g} {unit} and closes at {closing:.3g} {unit}; open, it "
            f"yields {ratio[0]:.2f} ({ratio[1]:.2f} to {ratio[2]:.2f}) times as much as the spring."
        )


def _unloaded_again(points: LoadedPoints) -> bool:
    """Whether some series takes a load off again, which alone tells a loop from a curve."""
    sizes = np.linalg.norm(points.wrenches[:, :3], axis=1)
    falls = (np.diff(sizes) < 0.0) & (np.diff(points.series) == 0)
    return bool(falls.any())
