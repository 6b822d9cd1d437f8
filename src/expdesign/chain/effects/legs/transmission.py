"""The transmission of a leg: its play, the leg that its force moves besides, and the error of its screw."""

from dataclasses import dataclass
from enum import StrEnum
from typing import ClassVar

import casadi as ca
import numpy as np

from expdesign.chain.actuator import Backlash, PeriodicError, Pitches
from expdesign.chain.component import Component, each_leg, on
from expdesign.chain.declaration import STRAIN_WAVE, Declaration, Input, Size, Variant
from expdesign.chain.effect import Parameter, When
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.chain.tabulated import TabulatedEffect
from expdesign.mechanics.robots.robot import Robot


class LegRest(StrEnum):
    """Where in its gap an unloaded leg rests."""

    MIDDLE = "middle"
    SHORT = "short"
    LONG = "long"


class LegBacklash(Backlash):
    """A leg has play: its length jumps by the gap where its force changes sign.

    Variants: the unloaded leg rests in the `middle` of the gap, or at its `short` or `long` end.
    """

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
    at = each_leg
    forms = tuple(LegRest)
    quantities = (Parameter("gap_{motion}", 1e-6, low=0.0, high=1e-2),)


@dataclass(frozen=True)
class Partner:
    """The leg whose force also deflects this one, and whether it is so the other way round."""

    leg: Component
    shared: bool

    def __str__(self) -> str:
        return f"{'shared with' if self.shared else 'force of'} {self.leg}"


class LegCoupling(TabulatedEffect):
    """The force in one leg deflects another, as through a mount that they share: Δq_j gains κ·τ_k.

    Variants: `force of leg k` (one way) and `shared with leg k` (both ways, as Maxwell and Betti have it for an elastic
    mount).
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
    at = each_leg
    quantities = (Parameter("coupling_{motion}_per_{force}", 1e-8, low=-1e-3, high=1e-3),)
    says = "The force of {variant.leg} also deflects {component}: {first:1e9 .3g} n{motion} per {force}."

    @classmethod
    def variants(cls, robot: Robot) -> list[Variant]:
        return [Partner(leg, shared) for shared in (False, True) for leg in each_leg(robot)]

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        legs = each_leg(robot)
        one_way = [(leg, Partner(other, False)) for leg in legs for other in legs if other != leg]
        shared = [(leg, Partner(other, True)) for i, leg in enumerate(legs) for other in legs[i + 1 :]]
        return [*one_way, *shared]

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        leg, other = self.component.index, self.variant.leg.index
        gained = ca.SX.zeros(elongation.shape[0])
        gained[leg] = theta[0] * force[other]
        if self.variant.shared:
            gained[other] = theta[0] * force[leg]
        return elongation + gained, state


class EncoderPeriodicError(PeriodicError):
    """A leg's commanded length has an error that repeats with the pitch of its screw.

    In deflections it is an offset of all rows of a series that depends on the leg's commanded length.
    """

    identifier = "legs.periodic_error"
    amplitude = (1e-6, 1e-2)
    pitches = {"m": Pitches(1e-4, 1e-3, 5e-5, 1e3, finest=5e-4)}  # noqa: RUF012
    noun = "length"
    at = on(lambda robot: set(robot.units) == {"m"}, each_leg)
    when: ClassVar[When] = lambda robot, points: len(np.unique(points.configurations, axis=0)) >= 4
