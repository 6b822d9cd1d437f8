"""The base or the ground deforms: a compliance fixed to the ground, in series with the legs."""

import casadi as ca

from expdesign.chain.components import symmetric
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.effects.platform.compliance import compliance_parameters
from expdesign.chain.row import Row
from expdesign.chain.support import measured_axes
from expdesign.recordings.recordings import LoadedPoints
from expdesign.robots.body import Body
from expdesign.robots.robot import Robot


class BaseCompliance(Effect):
    """The base moves by the twist C·F_O, F_O being the wrench referred to the origin of O, and carries all along.

    Variants: `diagonal` (an elastic support at the origin of O) and `full`.
    """

    physics = "base_compliance"

    @classmethod
    def places(cls, robot: Robot, points: LoadedPoints) -> list[tuple[str, str]]:
        # In the plane a base that only shifts moves as a mount on the platform does, and neither turns anything.
        if isinstance(robot, Body) and not measured_axes(points) & {0, 1, 2}:
            return []  # without translations this is what `support_compliance` says with fewer parameters
        return [("base", "diagonal"), ("base", "full")]

    def describe(self) -> tuple[Parameter, ...]:
        coordinates = self.robot.coordinates
        return compliance_parameters(coordinates.translations, coordinates.n, self.variant == "full")

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        n = self.robot.coordinates.n
        carry = ca.SX.eye(n)
        if n > 2:
            carry[:3, 3:] = -ca.skew(row.position)
        return deflection + row.rates @ carry @ symmetric(theta, n) @ carry.T @ (wrench + row.weight)

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        return "The base or the ground yields: the whole robot moves against the instrument under load."
