"""A leg has play: its length jumps by the gap where its force changes sign."""

from enum import StrEnum

from expdesign.chain.backlash import Backlash
from expdesign.chain.component import Component
from expdesign.chain.components import each_leg
from expdesign.robots.robot import Robot


class Rest(StrEnum):
    """Where in its gap an unloaded leg rests."""

    MIDDLE = "middle"
    SHORT = "short"
    LONG = "long"


class LegBacklash(Backlash):
    """Variants: the unloaded leg rests in the `middle` of the gap, or at its `short` or `long` end."""

    physics = "leg_backlash"
    forms = tuple(Rest)
    gap = (1e-6, 1e-2)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return each_leg(robot)
