"""The payload's centre of mass is not where it was assumed (theory.md 5.2: L = [0; −[m g]ₓ R])."""

from collections.abc import Sequence

import casadi as ca

from expdesign.chain.component import PAYLOAD, Component
from expdesign.chain.declaration import Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.mechanics.robots.orientation import moment
from expdesign.mechanics.robots.robot import Robot


class PayloadComOffset(Effect):
    """The force acts at R·(c + d): its moment about the origin of P grows by (R·d) × f."""

    physics = "payload_com_offset"
    declared = Declaration(
        left_out="error of the payload's centre of mass",
        phrase="a centre of mass that is not where it was assumed",
        usually="liquids, loose parts and drawings",
        port="centre of mass",
        inputs=(Input.FORCE,),
        sizes=(Size("com_d?_m", 1e-3, "assumed: centre of mass from a drawing, 1 mm"),),
    )

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [PAYLOAD] if robot.coordinates.centre_of_mass else []

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> Sequence[tuple[Component, Variant]]:
        # A body's wrench is about a known point; without payload columns there is no centre of mass that was assumed.
        return [] if robot.on_support and points.payload is None else super().shown(robot, points)

    def describe(self) -> tuple[Parameter, ...]:
        return tuple(Parameter(f"com_d{axis}_m", 1e-3, low=-0.5, high=0.5) for axis in self.robot.coordinates.axes)

    def load(self, wrench: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        split = self.robot.coordinates.translations
        return wrench + ca.vertcat(ca.SX.zeros(split), moment(row.rotation @ theta, wrench[:split]))

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        listed = ", ".join(f"{1e3 * v[0]:.2f}" for v in values.values())
        return (
            f"The payload's centre of mass lies ({listed}) mm from where it was assumed "
            "(platform axes); the direction along gravity is the least certain."
        )
