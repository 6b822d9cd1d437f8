"""Play in the joints of an arm, and play of a telescope that changes with its extension."""

from enum import StrEnum

import casadi as ca
import numpy as np

from expdesign.chain.actuator import SLACK, Acting, Backlash
from expdesign.chain.component import Component, each_joint, sliding_joints
from expdesign.chain.declaration import STRAIN_WAVE, WITH_EXTENSION, Declaration, Input, Size, Variant
from expdesign.chain.effect import Parameter
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.mechanics.robots.robot import Robot


class Rest(StrEnum):
    """Where in its gap a joint rests that nothing pushes."""

    MIDDLE = "middle"
    LOW = "low"
    HIGH = "high"


class JointBacklash(Backlash):
    """A joint has play: it jumps by the gap where its torque changes sign.

    The torque is the whole one, the weight of the links included: unloaded, a joint rests on the side to which the
    arm's own weight pushes it, and its play shows only when the load turns the torque round. A joint that nothing
    pushes (its axis is vertical, or it is balanced) rests in the `middle` of its gap, at its `low` or `high` end
    (variants).
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
        sizes=(Size("gap_rad", 3e-4, STRAIN_WAVE), Size("gap_m", 1e-5, "assumed: linear axis without preload")),
    )
    at = each_joint
    forms = tuple(Rest)
    quantities = (Parameter("gap_{motion}", 1e-5, low=0.0, high=0.1),)

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        own = points.measurand.reference(robot.own_weight(points.configurations, points.gravity))
        reference = points.absolute - points.wrenches
        own = own + (reference[:, None, :] @ robot.jacobians(points.configurations).forward)[:, 0]
        free = np.any(np.abs(own) <= SLACK, axis=0)
        joints = each_joint(robot)
        return [(joint, rest) for joint in joints for rest in (Rest if free[joint.index] else (Rest.MIDDLE,))]


class ExtensionPlay(Backlash):
    """A telescope's play along its axis changes with its extension: a worn spindle, a guide that overlaps less.

    The gap is `gap_m` + `gap_change`·q, and never negative; a joint that nothing pushes rests in its middle.
    """

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
    at = sliding_joints
    forms = (WITH_EXTENSION,)
    quantities = (Parameter("gap_m", 1e-5, low=0.0, high=0.1), Parameter("gap_change", 1e-5, low=-0.1, high=0.1))
    says = (
        "{subject} has {gap_m:1e6 .3g} µm of play drawn in, and {gap_change.best:1e6 +.3g} µm more for every metre of "
        "extension."
    )

    def gap(self, at: Acting, theta: ca.SX) -> ca.SX:
        gap = theta[0] + theta[1] * at.place
        # At a gap of 0 exactly, where every search starts, the slope must not be lost.
        return ca.if_else(gap < 0.0, 0.0, gap)
