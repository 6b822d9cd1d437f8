"""Errors of all joints' positions that repeat once and twice a turn: an eccentric and an oval scale or gear.

A calibration of an arm puts them there where it is asked to; `JointPeriodicError` is what a search looks for, with a
period of its own.
"""

import casadi as ca

from expdesign.chain.component import ALL_JOINTS, Component, each_joint
from expdesign.chain.declaration import Declaration, Input, Size
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot

_ORDERS = (1, 2)
"""Times a turn."""
_SPREAD = 1.5e-4
"""rad; the largest errors that makers of strain-wave gears state are twice this."""


class JointHarmonics(Effect):
    """Δq_k gains Σ_n a_nk·sin(n·q_k) + b_nk·cos(n·q_k), n = 1, 2, for every turning joint k."""

    physics = "encoder_periodic_error"
    declared = Declaration(
        left_out="errors of joints that repeat with every turn",
        phrase="periodic errors of the encoders of all joints",
        usually="eccentric and oval scales and gears",
        port="actuators",
        form="harmonic",
        laws=("periodic",),
        inputs=(Input.PLACE,),
        sizes=(Size("*_rad", _SPREAD, "assumed: as of a strain-wave gear"),),
    )
    measurands = ()

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [ALL_JOINTS] if each_joint(robot) and "rad" in robot.units else []

    @property
    def _turning(self) -> list[int]:
        return [index for index, unit in enumerate(self.robot.units) if unit == "rad"]

    def describe(self) -> tuple[Parameter, ...]:
        return tuple(
            Parameter(f"joint_{index + 1}_{name}_{order}_rad", 1e-5, low=-0.1, high=0.1, spread=_SPREAD)
            for index in self._turning
            for order in _ORDERS
            for name in ("sine", "cosine")
        )

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        gained, place = ca.SX.zeros(elongation.shape[0]), 0
        for index in self._turning:
            for order in _ORDERS:
                angle = order * row.lengths[index]
                gained[index] += theta[place] * ca.sin(angle) + theta[place + 1] * ca.cos(angle)
                place += 2
        return elongation + gained, state

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        largest = max(values, key=lambda name: abs(values[name][0]))
        return f"Errors of the joints repeat with every turn, the largest ({largest}) by {values[largest][0]:.3g} rad."
