"""Loading and unloading differ: dry friction beside the spring of a leg or joint.

A spring k_t that slips at the friction F acts beside the leg's spring k (a Jenkins element). While it sticks the leg is
stiffer, and what it carries when the load returns is the hysteresis. With a rigid slider the leg follows its force only
when that has moved by more than F (the play operator). Where friction is known by its loop alone, the leg lags behind
its force by F against the sense of the last change, however small that was.
"""

from enum import StrEnum

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import Component, actuators_and_all, turning
from expdesign.chain.declaration import Declaration, Input, Size
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot

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

    physics = "friction_hysteresis"
    declared = Declaration(
        left_out="loading and unloading differ",
        phrase="friction in {component}",
        usually="guides, seals and clamped joints",
        port="actuators",
        inputs=(Input.FORCE, Input.HISTORY),
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
