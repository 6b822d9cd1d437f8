"""A leg has play: its length jumps by the gap where its force changes sign.

The force in one leg deflects another, as through a mount that they share.

A leg's commanded length has an error that repeats with the pitch of its screw.

In deflections it is an offset of all rows of a series that depends on the leg's commanded length.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import casadi as ca
import numpy as np

from expdesign.chain.backlash import Backlash
from expdesign.chain.component import Component, each_leg, turning
from expdesign.chain.declaration import STRAIN_WAVE, Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.periodic_error import PeriodicError, Pitches
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


class LegRest(StrEnum):
    """Where in its gap an unloaded leg rests."""

    MIDDLE = "middle"
    SHORT = "short"
    LONG = "long"


class LegBacklash(Backlash):
    """Variants: the unloaded leg rests in the `middle` of the gap, or at its `short` or `long` end."""

    identifier = "legs.backlash"
    physics = "leg_backlash"
    declared = Declaration(
        left_out="play of a leg",
        linear=False,
        phrase="play in {component}",
        usually="worn nuts and spherical joints",
        port="actuators",
        form="gap",
        laws=("step at zero",),
        inputs=(Input.FORCE,),
        sizes=(
            Size(
                "gap_m",
                1.5e-6,
                "V. J. Kalas, PhD thesis, Montpellier 2020 (HAL tel-03154741): hexapod repeatability ±0.75 µm; "
                "a gap is no wider",
            ),
            Size("gap_rad", 3e-4, STRAIN_WAVE),
        ),
    )
    forms = tuple(LegRest)
    gap = (1e-6, 1e-2)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return each_leg(robot)


@dataclass(frozen=True)
class Partner:
    """The leg whose force also deflects this one, and whether it is so the other way round."""

    leg: Component
    shared: bool

    def __str__(self) -> str:
        return f"{'shared with' if self.shared else 'force of'} {self.leg}"


class LegCoupling(Effect):
    """Δq_j gains κ·τ_k. Variants: `force of leg k` (one way) and `shared with leg k` (both ways, as Maxwell and Betti
    have it for an elastic mount).
    """

    identifier = "legs.coupling"
    physics = "leg_coupling"
    declared = Declaration(
        left_out="the force in one leg deflects another",
        phrase="a force in another leg that moves {component}",
        usually="mounts that legs share",
        port="actuators",
        laws=("bracket",),
        inputs=(Input.FORCE,),
        sizes=(Size("coupling_*", 0.05, "assumed: mounts that two legs share", "actuator compliance"),),
    )

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return each_leg(robot)

    @classmethod
    def variants(cls, robot: Robot) -> list[Variant]:
        return [Partner(leg, shared) for shared in (False, True) for leg in each_leg(robot)]

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        legs = each_leg(robot)
        one_way = [(leg, Partner(other, False)) for leg in legs for other in legs if other != leg]
        shared = [(leg, Partner(other, True)) for i, leg in enumerate(legs) for other in legs[i + 1 :]]
        return [*one_way, *shared]

    def describe(self) -> tuple[Parameter, ...]:
        return (
            Parameter(
                "coupling_rad_per_Nm" if turning(self.robot, self.actuators) else "coupling_m_per_N",
                1e-8,
                low=-1e-3,
                high=1e-3,
            ),
        )

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        leg, other = self.component.index, self.variant.leg.index
        gained = ca.SX.zeros(elongation.shape[0])
        gained[leg] = theta[0] * force[other]
        if self.variant.shared:
            gained[other] = theta[0] * force[leg]
        return elongation + gained, state

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        name, v = next(iter(values.items()))
        unit = "nrad per newton metre" if "rad" in name else "nm per newton"
        return (
            f"The force of {self.variant.leg} also deflects {self.component}: {1e9 * v[0]:.3g} ({1e9 * v[1]:.3g} to "
            f"{1e9 * v[2]:.3g}) {unit}."
        )


class EncoderPeriodicError(PeriodicError):
    """Of the screw of a leg."""

    identifier = "legs.periodic_error"
    amplitude = (1e-6, 1e-2)
    pitches = {"m": Pitches(1e-4, 1e-3, 5e-5, 1e3, finest=5e-4)}  # noqa: RUF012
    noun = "length"

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return each_leg(robot) if set(robot.units) == {"m"} else []

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> Sequence[tuple[Component, Variant]]:
        commands = len(np.unique(points.configurations, axis=0))
        return super().shown(robot, points) if commands >= 4 else []
