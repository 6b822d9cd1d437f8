"""A joint has play: it jumps by the gap where its torque changes sign.

The torque is the whole one, the weight of the links included: unloaded, a joint rests on the side to which the arm's
own weight pushes it, and its play shows only when the load turns the torque round. A joint that nothing pushes (its
axis is vertical, or it is balanced) rests somewhere in the gap.
"""

from enum import StrEnum

import casadi as ca
import numpy as np

from expdesign.chain.component import Component
from expdesign.chain.components import each_joint, turning
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.play import SLACK, with_play
from expdesign.chain.row import Row
from expdesign.chain.variant import Variant
from expdesign.recordings.recordings import LoadedPoints
from expdesign.robots.robot import Robot


class Rest(StrEnum):
    """Where in its gap a joint rests that nothing pushes."""

    MIDDLE = "middle"
    LOW = "low"
    HIGH = "high"


_ENDS = {Rest.MIDDLE: (0.5, -0.5), Rest.LOW: (1.0, 0.0), Rest.HIGH: (0.0, -1.0)}
"""Ends of the gap, in gaps, relative to where a joint without torque rests."""


class JointBacklash(Effect):
    """Variants, which matter where nothing pushes: the joint rests in the `middle` of its gap, at its `low` or `high`
    end.
    """

    physics = "joint_backlash"
    forms = tuple(Rest)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return each_joint(robot)

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        joints = each_joint(robot)
        if not joints:
            return []
        own = points.measurand.reference(robot.own_weight(points.configurations, points.gravity))
        reference = points.absolute - points.wrenches
        own = own + (reference[:, None, :] @ robot.jacobians(points.configurations).forward)[:, 0]
        places: list[tuple[Component, Variant]] = []
        for index, joint in enumerate(joints):
            free = bool(np.any(np.abs(own[:, index]) <= SLACK))
            places += [(joint, rest) for rest in (Rest if free else (Rest.MIDDLE,))]
        return places

    def describe(self) -> tuple[Parameter, ...]:
        return (Parameter("gap_rad" if turning(self.robot, self.actuators) else "gap_m", 1e-5, low=0.0, high=0.1),)

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        return with_play(elongation, force, row, self.component.index, theta[0], _ENDS[self.variant]), state

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        name, value = next(iter(values.items()))
        size = f"{1e6 * value[0]:.3g} ({1e6 * value[1]:.3g} to {1e6 * value[2]:.3g})"
        unit = "µrad" if name == "gap_rad" else "µm"
        return f"{self.subject} has {size} {unit} of play."
