"""Positions were read before the arm had settled: its joints had not yet come where they were sent.

The joints stand at 1 − ρ of the way from where they stood in the row before to the command, so that the logged minus
the commanded joints are a common fraction of each row's step. To first order in ρ·step; a series starts settled.
"""

import casadi as ca

from expdesign.chain.effect import Parameter
from expdesign.chain.recordings.recordings import POSITIONS
from expdesign.chain.row import Row
from expdesign.chain.unsettled import Unsettled


class ReadBeforeSettled(Unsettled):
    """q = q_C − ρ·(q_C − q of the row before); ρ is `unsettled_step_fraction`, the same for all joints."""

    measurands = (POSITIONS,)

    def describe(self) -> tuple[Parameter, ...]:
        self.states = len(self.robot.stiffness)
        return (Parameter("unsettled_step_fraction", 1e-3, low=-0.5, high=0.95),)

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        step = (1.0 - row.first) * (row.lengths - state)
        missing = theta[0] * step
        return elongation - missing, row.lengths - missing

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        v = values["unsettled_step_fraction"]
        size = f"{100 * v[0]:.3g} % ({100 * v[1]:.3g} to {100 * v[2]:.3g} %)"
        return f"Positions were read before the arm had settled: {size} of every joint's step was still missing."
