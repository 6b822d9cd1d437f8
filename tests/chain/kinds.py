"""The effect that is for a robot, where one physics is several effects on several kinds of robots."""

from expdesign.chain.effect import Effect
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.mechanics.robots.robot import Robot
from expdesign.plugins import implementations

KINDS: list[type[Effect]] = implementations("expdesign.chain.effects", Effect)


def kind_for(robot: Robot, points: LoadedPoints, physics: str) -> type[Effect]:
    """The effect of this physics that has a place on the robot, else the first of this physics."""
    kinds = [kind for kind in KINDS if kind.physics == physics]
    return next((kind for kind in kinds if kind.places(robot, points)), kinds[0])
