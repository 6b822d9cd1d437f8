"""The force in one leg deflects another, as through a mount that they share."""

from dataclasses import dataclass

import casadi as ca

from expdesign.chain.component import Component, each_leg, turning
from expdesign.chain.declaration import Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


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

    physics = "leg_coupling"
    declared = Declaration(
        left_out="the force in one leg deflects another",
        phrase="a force in another leg that moves {component}",
        usually="mounts that legs share",
        port="actuators",
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
