"""Play of an arm's joints about or along their own axes, the same everywhere or changing with the extension."""

from dataclasses import replace

import numpy as np

from expdesign.chain.component import each_joint, sliding_joints
from expdesign.chain.declaration import STRAIN_WAVE, Input, Parameter, Size
from expdesign.chain.effect import Effect, Shows
from expdesign.chain.effects.legs.transmission import LegBacklash
from expdesign.chain.form import Form
from expdesign.chain.play import SLACK, play, resting
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.mechanics.robots.robot import Robot


def _pushed_by_nothing(robot: Robot, points: LoadedPoints) -> Shows:
    """A joint that its own weight or the reference load pushes rests at one place, which its forms call the middle."""
    own = points.measurand.reference(robot.own_weight(points.configurations, points.gravity))
    reference = points.absolute - points.wrenches
    own = own + (reference[:, None, :] @ robot.jacobians(points.configurations).forward)[:, 0]
    free = np.any(np.abs(own) <= SLACK, axis=0)
    return lambda joint, rest: str(rest) == "middle" or free[joint.index]


class JointBacklash(Effect):
    """A joint has play: it jumps by the gap where its torque changes sign.

    The torque is the whole one, the weight of the links included: unloaded, a joint rests on the side to which the
    arm's own weight pushes it, and its play shows only when the load turns the torque round. A joint that nothing
    pushes (its axis is vertical, or it is balanced) rests in the `middle` of its gap, at its `low` or `high` end
    (variants).
    """

    identifier = "joints.backlash"
    physics = "joint_backlash"
    declared = replace(
        LegBacklash.declared,
        left_out="play of a joint",
        usually="worn gears and couplings",
        sizes=(Size("gap_rad", 3e-4, STRAIN_WAVE), Size("gap_m", 1e-5, "assumed: linear axis without preload")),
    )
    at = each_joint
    shows = _pushed_by_nothing
    forms = resting("low", "high")
    quantities = (Parameter("gap_{motion}", 1e-5, low=0.0, high=0.1),)
    says = LegBacklash.says


class ExtensionPlay(Effect):
    """A telescope's play along its axis changes with its extension: a worn spindle, a guide that overlaps less.

    A joint that nothing pushes rests in the middle of its gap.
    """

    identifier = "joints.extension_play"
    physics = "joint_backlash"
    declared = replace(
        JointBacklash.declared,
        left_out="play of a joint, the more the farther it is drawn out",
        linear=True,
        usually="worn guides",
        laws=(),
        inputs=(Input.FORCE, Input.PLACE),
        sizes=(
            Size("gap_m", 1e-5, "assumed: linear axis without preload"),
            Size("gap_change", 1e-4, "assumed: a guide that is worn over a part of its travel"),
        ),
    )
    at = sliding_joints
    forms = (Form(play, "with extension"),)
    quantities = (Parameter("gap_m", 1e-5, low=0.0, high=0.1), Parameter("gap_change", 1e-5, low=-0.1, high=0.1))
    says = (
        "{subject} has {gap_m:1e6 .3g} µm of play drawn in, and {gap_change.best:1e6 +.3g} µm more for every metre of "
        "extension."
    )
