"""A leg has play: its length jumps by the gap where its force changes sign."""

import casadi as ca

from expdesign.chain.components import each_leg
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.play import with_play
from expdesign.chain.row import Row
from expdesign.recordings.recordings import LoadedPoints
from expdesign.robots.robot import Robot

_ENDS = {"middle": (0.5, -0.5), "short": (1.0, 0.0), "long": (0.0, -1.0)}
"""Long and short end of the gap, in gaps, relative to where the unloaded leg rests."""


class LegBacklash(Effect):
    """Δq gains the way from where the unloaded leg rests to the end of the gap at which its force holds it.

    Variants: the unloaded leg rests in the `middle` of the gap, or at its `short` or `long` end.
    """

    physics = "leg_backlash"

    @classmethod
    def places(cls, robot: Robot, points: LoadedPoints) -> list[tuple[str, str]]:
        return [(leg, rest) for leg in each_leg(robot) for rest in ("middle", "short", "long")]

    def describe(self) -> tuple[Parameter, ...]:
        return (Parameter("gap_m", 1e-6, low=0.0, high=1e-2),)

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        return with_play(elongation, force, row, self.leg, theta[0], _ENDS[self.variant]), state

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        gap, low, high = (1e6 * value for value in values["gap_m"])
        return f"{self.component.capitalize()} has {gap:.2f} ({low:.2f} to {high:.2f}) µm of play."
