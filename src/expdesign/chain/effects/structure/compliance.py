"""Compliances in series with the legs, fixed to the platform and to the ground."""

from abc import abstractmethod
from typing import ClassVar

import casadi as ca

from expdesign.chain.component import BASE, PLATFORM, on, on_any, symmetric
from expdesign.chain.declaration import TEN_PERCENT, Declaration, Input, Size
from expdesign.chain.effect import Effect, Parameter, When
from expdesign.chain.form import Form
from expdesign.chain.recordings.recordings import measured_axes
from expdesign.chain.row import Row
from expdesign.coordinates import Coordinates
from expdesign.mechanics.robots.orientation import frame_turn, twist_transfer

_DIAGONAL, _FULL = Form(name="diagonal"), Form(name="full")
"""Which elements of a compliance are not zero."""


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


class _Carrier(Effect):
    """What carries the platform moves by the twist C·F, F being the wrench that passes through it."""

    forms = (_DIAGONAL, _FULL)

    def describe(self) -> tuple[Parameter, ...]:
        return compliance_parameters(self.robot.coordinates, self.variant == _FULL)

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        carry, load = self.through(wrench, row, self.robot.coordinates.n)
        return deflection + row.rates @ carry @ symmetric(theta, load.shape[0]) @ carry.T @ load

    @abstractmethod
    def through(self, wrench: ca.SX, row: Row, n: int) -> tuple[ca.SX, ca.SX]:
        """The transfer (n, n) of its twist to the platform, and the wrench (n,) at the platform that loads it."""


class PlatformCompliance(_Carrier):
    """The platform or the payload's mount deforms: a compliance fixed to the platform, in series with the legs.

    ΔX gains T·diag(R, R)·C·diag(R, R)ᵀ·F with C constant in the platform frame, about the origin of P.

    Variants: `diagonal` (an elastic mount at the origin) and `full` (anywhere, any shape).
    """

    identifier = "platform.compliance"
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
    at = on(lambda robot: not robot.on_support, PLATFORM)  # a body is rigid; what it stands on yields
    says = "The platform or the payload's mount yields: the payload moves against the joints' plate under load."

    def through(self, wrench: ca.SX, row: Row, n: int) -> tuple[ca.SX, ca.SX]:
        return frame_turn(row.rotation, n), wrench


class BaseCompliance(_Carrier):
    """The base or the ground deforms: a compliance fixed to the ground, in series with the legs.

    The base moves by the twist C·F_O, F_O being the wrench referred to the origin of O, and carries all along.

    Variants: `diagonal` (an elastic support at the origin of O) and `full`.
    """

    identifier = "base.compliance"
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
    # In the plane a base that only shifts moves as a mount on the platform does, and neither turns anything.
    at = on_any(BASE)
    # Without translations this is what `support.compliance` of a body says with fewer parameters.
    when: ClassVar[When] = lambda robot, points: not robot.on_support or measured_axes(points) & {0, 1, 2}
    says = "The base or the ground yields: the whole robot moves against the instrument under load."

    def through(self, wrench: ca.SX, row: Row, n: int) -> tuple[ca.SX, ca.SX]:
        return twist_transfer(row.position, n), wrench + row.weight
