"""What readings and positions that were taken before an arm had settled have in common, as effects."""

from collections.abc import Sequence
from enum import StrEnum

import numpy as np

from expdesign.chain.component import ALL_JOINTS, Component
from expdesign.chain.declaration import Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.mechanics.robots.robot import Robot


class Cause(StrEnum):
    """Unlike creep, which shares its physics, it is no property of the arm."""

    UNSETTLED = "logged before settled"


class Unsettled(Effect):
    """A common fraction of every joint's step from the row before is still missing; the states are the joints'."""

    physics = "creep"
    declared = Declaration(
        left_out="readings before the machine had settled",
        phrase="creep of {component}",
        usually="readings that were taken too soon",
        port="actuators",
        inputs=(Input.FORCE, Input.HISTORY),
        sizes=(Size("unsettled_*fraction", 0.02, "assumed: read when 98 % of a move have settled"),),
    )
    forms = tuple(Cause)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [ALL_JOINTS] if robot.jointed else []

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> Sequence[tuple[Component, Variant]]:
        several = len(np.unique(points.series)) < len(points)
        return super().shown(robot, points) if several else []
