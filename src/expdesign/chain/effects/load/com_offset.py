"""The payload's centre of mass is not where it was assumed (theory.md 5.2: L = [0; −[m g]ₓ R])."""

import casadi as ca

from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.recordings.recordings import LoadedPoints
from expdesign.robots.body import Body
from expdesign.robots.robot import Robot


class PayloadComOffset(Effect):
    """The force acts at R·(c + d): its moment about the origin of P grows by (R·d) × f."""

    physics = "payload_com_offset"

    @classmethod
    def places(cls, robot: Robot, points: LoadedPoints) -> list[tuple[str, str]]:
        # A body's wrench is about a known point; without payload columns there is no centre of mass that was assumed.
        only_changes = isinstance(robot, Body) and points.payload is None
        return [("payload", "")] if robot.coordinates.centre_of_mass and not only_changes else []

    def describe(self) -> tuple[Parameter, ...]:
        return tuple(Parameter(f"com_d{axis}_m", 1e-3, low=-0.5, high=0.5) for axis in "xyz")

    def load(self, wrench: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        return wrench + ca.vertcat(ca.SX.zeros(3), ca.cross(row.rotation @ theta, wrench[:3]))

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        x, y, z = (1e3 * values[f"com_d{axis}_m"][0] for axis in "xyz")
        return (
            f"The payload's centre of mass lies ({x:.2f}, {y:.2f}, {z:.2f}) mm from where it was assumed "
            "(platform axes); the direction along gravity is the least certain."
        )
