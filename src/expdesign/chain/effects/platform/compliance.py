"""The platform or the payload's mount deforms: a compliance fixed to the platform, in series with the legs."""

from enum import StrEnum

import casadi as ca

from expdesign.chain.component import PLATFORM, Component, symmetric
from expdesign.chain.declaration import TEN_PERCENT, Declaration, Input, Size
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.coordinates import Coordinates
from expdesign.mechanics.robots.orientation import frame_turn
from expdesign.mechanics.robots.robot import Robot


class Shape(StrEnum):
    """Which elements of a compliance are not zero."""

    DIAGONAL = "diagonal"
    FULL = "full"


def compliance_parameters(coordinates: Coordinates, full: bool) -> tuple[Parameter, ...]:
    """Entries of a symmetric compliance, diagonal first, then the upper triangle by rows."""
    n = coordinates.n
    names = [f"d{axis}" for axis in coordinates.axes] + [f"r{axis}" for axis in coordinates.rotation_axes]
    units = {"dd": ("m_per_N", 1e-9), "dr": ("per_N", 1e-8), "rr": ("rad_per_Nm", 1e-7)}
    # A part that yields by 1 mm under 1 N, or turns by 0.1 rad under 1 N·m, carries nothing; between, their mean.
    softest = {"dd": 1e-3, "dr": 1e-2, "rr": 1e-1}

    def parameter(i: int, j: int) -> Parameter:
        kind = "".join(sorted(names[i][0] + names[j][0]))
        (unit, scale), high = units[kind], softest[kind]
        return Parameter(f"compliance_{names[i]}_{names[j]}_{unit}", scale, low=0.0 if i == j else -high, high=high)

    diagonal = [parameter(i, i) for i in range(n)]
    upper = [parameter(i, j) for i in range(n) for j in range(i + 1, n)] if full else []
    return tuple(diagonal + upper)


class PlatformCompliance(Effect):
    """ΔX gains T·diag(R, R)·C·diag(R, R)ᵀ·F with C constant in the platform frame, about the origin of P.

    Variants: `diagonal` (an elastic mount at the origin) and `full` (anywhere, any shape).
    """

    physics = "platform_compliance"
    declared = Declaration(
        left_out="compliance of the platform or of the payload's mount",
        phrase="a soft platform",
        usually="plates, mounts and bolted joints",
        port="platform",
        laws=("compliance", "force law"),
        inputs=(Input.FORCE,),
        sizes=(Size("compliance_*", 0.1, TEN_PERCENT, "pose compliance"),),
    )
    forms = tuple(Shape)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [] if robot.on_support else [PLATFORM]  # a body is rigid; what it stands on yields

    def describe(self) -> tuple[Parameter, ...]:
        return compliance_parameters(self.robot.coordinates, self.variant is Shape.FULL)

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        n = self.robot.coordinates.n
        turn = frame_turn(row.rotation, n)
        return deflection + row.rates @ turn @ symmetric(theta, n) @ turn.T @ wrench

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        return "The platform or the payload's mount yields: the payload moves against the joints' plate under load."
