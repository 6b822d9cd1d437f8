"""The base or the ground deforms: a compliance fixed to the ground, in series with the legs."""

from collections.abc import Sequence

import casadi as ca

from expdesign.chain.component import BASE, Component, symmetric
from expdesign.chain.declaration import TEN_PERCENT, Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.effects.platform.compliance import Shape, compliance_parameters
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.chain.support import measured_axes
from expdesign.mechanics.robots.orientation import twist_transfer
from expdesign.mechanics.robots.robot import Robot


class BaseCompliance(Effect):
    """The base moves by the twist C·F_O, F_O being the wrench referred to the origin of O, and carries all along.

    Variants: `diagonal` (an elastic support at the origin of O) and `full`.
    """

    physics = "base_compliance"
    declared = Declaration(
        left_out="compliance of the base or the ground",
        phrase="a soft base",
        usually="stands, floors and bolted feet",
        port="base",
        laws=("compliance", "force law"),
        inputs=(Input.FORCE,),
        sizes=(Size("compliance_*", 0.1, TEN_PERCENT, "pose compliance"),),
    )
    forms = tuple(Shape)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        # In the plane a base that only shifts moves as a mount on the platform does, and neither turns anything.
        return [BASE]

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> Sequence[tuple[Component, Variant]]:
        if robot.on_support and not measured_axes(points) & {0, 1, 2}:
            return []  # without translations this is what `support.compliance` says with fewer parameters
        return super().shown(robot, points)

    def describe(self) -> tuple[Parameter, ...]:
        return compliance_parameters(self.robot.coordinates, self.variant is Shape.FULL)

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        n = self.robot.coordinates.n
        carry = twist_transfer(row.position, n)
        return deflection + row.rates @ carry @ symmetric(theta, n) @ carry.T @ (wrench + row.weight)

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        return "The base or the ground yields: the whole robot moves against the instrument under load."
