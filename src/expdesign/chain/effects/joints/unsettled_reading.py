"""Readings were logged before the arm had settled: part of the step from the row before is still missing.

A row's joints have moved from where they were in the row before it (unloaded, at the start of a series) to 1 − ρ of the
way to where the load takes them. Unlike creep it does not depend on how long the interval is, and it ends with the row.
"""

import casadi as ca

from expdesign.chain.effect import Parameter
from expdesign.chain.recordings.recordings import DEFLECTIONS
from expdesign.chain.row import Row
from expdesign.chain.unsettled import Unsettled


class LoggedBeforeSettled(Unsettled):
    """Δq = Δq(load) − ρ·(Δq(load) − Δq(row before)); ρ is `unsettled_fraction`, the same for all joints."""

    measurands = (DEFLECTIONS,)

    def describe(self) -> tuple[Parameter, ...]:
        self.states = len(self.robot.stiffness)
        return (Parameter("unsettled_fraction", 0.05, low=-0.5, high=0.95),)

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        reached = elongation - theta[0] * (elongation - state)
        return reached, reached

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        v = values["unsettled_fraction"]
        size = f"{100 * v[0]:.1f} % ({100 * v[1]:.1f} to {100 * v[2]:.1f} %)"
        return f"Readings were logged before the arm had settled: {size} of every step was still missing."
