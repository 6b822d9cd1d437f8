"""A joint has play: it jumps by the gap where its torque changes sign.

The torque is the whole one, the weight of the links included: unloaded, a joint rests on the side to which the arm's
own weight pushes it, and its play shows only when the load turns the torque round. A joint that nothing pushes (its
axis is vertical, or it is balanced) rests somewhere in the gap.
"""

from enum import StrEnum

import numpy as np

from expdesign.chain.backlash import SLACK, Backlash
from expdesign.chain.component import Component, each_joint
from expdesign.chain.declaration import STRAIN_WAVE, Declaration, Input, Size, Variant
from expdesign.chain.recordings.recordings import LoadedPoints
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

    physics = "joint_backlash"
    declared = Declaration(
        left_out="play of a joint",
        phrase="play in {component}",
        usually="worn gears and couplings",
        port="actuators",
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
