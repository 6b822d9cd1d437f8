"""A leg has play: its length jumps by the gap where its force changes sign."""

from enum import StrEnum

import casadi as ca

from expdesign.chain.component import Component
from expdesign.chain.components import each_leg, turning
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.play import with_play
from expdesign.chain.row import Row
from expdesign.robots.robot import Robot


class Rest(StrEnum):
    """Where in its gap an unloaded leg rests."""

    MIDDLE = "middle"
    SHORT = "short"
    LONG = "long"


_ENDS = {Rest.MIDDLE: (0.5, -0.5), Rest.SHORT: (1.0, 0.0), Rest.LONG: (0.0, -1.0)}
"""Long and short end of the gap, in gaps, relative to where the unloaded leg rests."""


class LegBacklash(Effect):
    """Δq gains the way from where the unloaded leg rests to the end of the gap at which its force holds it.

    Variants: the unloaded leg rests in the `middle` of the gap, or at its `short` or `long` end.
    """

    physics = "leg_backlash"
    forms = tuple(Rest)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return each_leg(robot)

    def describe(self) -> tuple[Parameter, ...]:
        return (Parameter("gap_rad" if turning(self.robot, self.actuators) else "gap_m", 1e-6, low=0.0, high=1e-2),)

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        return with_play(elongation, force, row, self.component.index, theta[0], _ENDS[self.variant]), state

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        name, value = next(iter(values.items()))
        gap, low, high = (1e6 * each for each in value)
        unit = "µrad" if name == "gap_rad" else "µm"
        return f"{self.subject} has {gap:.2f} ({low:.2f} to {high:.2f}) {unit} of play."
