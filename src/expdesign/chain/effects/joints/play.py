"""A joint has play: it jumps by the gap where its torque changes sign.

The torque is the whole one, the weight of the links included: unloaded, a joint rests on the side to which the arm's
own weight pushes it, and its play shows only when the load turns the torque round. A joint that nothing pushes (its
axis is vertical, or it is balanced) rests somewhere in the gap.

A telescope's play along its axis changes with its extension: a worn spindle, a guide that overlaps less.
"""

from enum import StrEnum
from typing import ClassVar

import casadi as ca
import numpy as np

from expdesign.chain.backlash import SLACK, Backlash, with_play
from expdesign.chain.component import Component, each_joint, sliding_joints
from expdesign.chain.declaration import STRAIN_WAVE, Declaration, Extension, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


class Rest(StrEnum):
    """Where in its gap a joint rests that nothing pushes."""

    MIDDLE = "middle"
    LOW = "low"
    HIGH = "high"


class JointBacklash(Backlash):
    """Variants, which matter where nothing pushes: the joint rests in the `middle` of its gap, at its `low` or `high`
    end.
    """

    identifier = "joints.backlash"
    physics = "joint_backlash"
    declared = Declaration(
        left_out="play of a joint",
        linear=False,
        phrase="play in {component}",
        usually="worn gears and couplings",
        port="actuators",
        form="gap",
        laws=("step at zero",),
        inputs=(Input.FORCE,),
        sizes=(
            Size("gap_rad", 3e-4, STRAIN_WAVE),
            Size("gap_m", 1e-5, "assumed: linear axis without preload"),
        ),
    )
    forms = tuple(Rest)
    gap = (1e-5, 0.1)

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


class ExtensionPlay(Effect):
    """The gap is `gap_m` + `gap_change`·q, and never negative; a joint that nothing pushes rests in its middle."""

    identifier = "joints.extension_play"
    physics = "joint_backlash"
    declared = Declaration(
        left_out="play of a joint, the more the farther it is drawn out",
        phrase="play in {component}",
        usually="worn guides",
        port="actuators",
        form="gap",
        inputs=(Input.FORCE, Input.PLACE),
        sizes=(
            Size("gap_m", 1e-5, "assumed: linear axis without preload"),
            Size("gap_change", 1e-4, "assumed: a guide that is worn over a part of its travel"),
        ),
    )
    forms: ClassVar[tuple[Variant, ...]] = tuple(Extension)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return sliding_joints(robot)

    def describe(self) -> tuple[Parameter, ...]:
        return (Parameter("gap_m", 1e-5, low=0.0, high=0.1), Parameter("gap_change", 1e-5, low=-0.1, high=0.1))

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        index = self.component.index
        gap = theta[0] + theta[1] * row.lengths[index]
        # At a gap of 0 exactly, where every search starts, the slope must not be lost.
        gap = ca.if_else(gap < 0.0, 0.0, gap)
        return with_play(elongation, force, row, index, gap, (0.5, -0.5)), state

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        gap, change = values["gap_m"], values["gap_change"]
        return (
            f"{self.subject} has {1e6 * gap[0]:.3g} ({1e6 * gap[1]:.3g} to {1e6 * gap[2]:.3g}) µm of play drawn in, "
            f"and {1e6 * change[0]:+.3g} µm more for every metre of extension."
        )
