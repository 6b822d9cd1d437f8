"""A leg has play: its length jumps by the gap where its force changes sign."""

import casadi as ca

from expdesign.chain.components import each_leg, reference_force
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.recordings.recordings import LoadedPoints
from expdesign.robots.robot import Robot

_SLACK = 1e-3
"""N; a leg with less force than this rests where it rested unloaded."""


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
        before = reference_force(row)[self.leg]
        gained = ca.SX.zeros(elongation.shape[0])
        gained[self.leg] = theta[0] * (self._place(before + force[self.leg]) - self._place(before))
        return elongation + gained, state

    def _place(self, force: ca.SX) -> ca.SX:
        """Place within the gap, in gaps, relative to where the unloaded leg rests."""
        long_end, short_end = {"middle": (0.5, -0.5), "short": (1.0, 0.0), "long": (0.0, -1.0)}[self.variant]
        return ca.if_else(force > _SLACK, long_end, ca.if_else(force < -_SLACK, short_end, 0.0))

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        gap, low, high = (1e6 * value for value in values["gap_m"])
        return f"{self.component.capitalize()} has {gap:.2f} ({low:.2f} to {high:.2f}) µm of play."
