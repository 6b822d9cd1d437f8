"""The instrument's scale is wrong on one or more axes."""

import casadi as ca

from expdesign.chain.component import INSTRUMENT, Component
from expdesign.chain.declaration import Declaration, Size
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


class InstrumentScale(Effect):
    """It reads (1 + s_i)·d_i on the translational axes."""

    physics = "instrument_scale"
    declared = Declaration(
        left_out="wrong scale of the instrument",
        phrase="a wrong scale of the instrument",
        usually="optics and electronics that are not calibrated",
        port="instrument",
        sizes=(Size("scale_?", 1e-3, "assumed: gauges calibrated to 0.1 % of their range"),),
    )

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [INSTRUMENT]

    def describe(self) -> tuple[Parameter, ...]:
        axes = self.robot.coordinates.axes
        return tuple(Parameter(f"scale_{axis}", 1e-2, low=-0.9, high=9.0) for axis in axes)

    def reading(self, reading: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        rest = ca.SX.zeros(reading.shape[0] - theta.shape[0])
        return reading * (1.0 + ca.vertcat(theta, rest))

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        parts = ", ".join(f"{100 * v[0]:+.2f} % on {name[-1]}" for name, v in values.items())
        return f"The instrument's scale is off: {parts}."
