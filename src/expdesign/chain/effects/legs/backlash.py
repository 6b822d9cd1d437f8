"""A leg has play: its length jumps by the gap where its force changes sign."""

from enum import StrEnum

from expdesign.chain.backlash import Backlash
from expdesign.chain.component import Component, each_leg
from expdesign.chain.declaration import STRAIN_WAVE, Declaration, Input, Size
from expdesign.mechanics.robots.robot import Robot


class LegRest(StrEnum):
    """Where in its gap an unloaded leg rests."""

    MIDDLE = "middle"
    SHORT = "short"
    LONG = "long"


class LegBacklash(Backlash):
    """Variants: the unloaded leg rests in the `middle` of the gap, or at its `short` or `long` end."""

    physics = "leg_backlash"
    declared = Declaration(
        left_out="play of a leg",
        phrase="play in {component}",
        usually="worn nuts and spherical joints",
        port="actuators",
        inputs=(Input.FORCE,),
        sizes=(
            Size(
                "gap_m",
                1.5e-6,
                "V. J. Kalas, PhD thesis, Montpellier 2020 (HAL tel-03154741): hexapod repeatability ±0.75 µm; "
                "a gap is no wider",
            ),
            Size("gap_rad", 3e-4, STRAIN_WAVE),
        ),
    )
    forms = tuple(LegRest)
    gap = (1e-6, 1e-2)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return each_leg(robot)
