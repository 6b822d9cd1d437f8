"""The force in one leg deflects another, as through a mount that they share."""

import casadi as ca

from expdesign.chain.components import each_leg
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.recordings.recordings import LoadedPoints
from expdesign.robots.robot import Robot


class LegCoupling(Effect):
    """Δq_j gains κ·τ_k. Variants: `force of leg k` (one way) and `shared with leg k` (both ways, as Maxwell and Betti
    have it for an elastic mount).
    """

    physics = "leg_coupling"

    @classmethod
    def places(cls, robot: Robot, points: LoadedPoints) -> list[tuple[str, str]]:
        legs = each_leg(robot)
        one_way = [(leg, f"force of {other}") for leg in legs for other in legs if other != leg]
        shared = [(leg, f"shared with {other}") for i, leg in enumerate(legs) for other in legs[i + 1 :]]
        return one_way + shared

    def describe(self) -> tuple[Parameter, ...]:
        return (Parameter("coupling_m_per_N", 1e-8, low=-1e-3, high=1e-3),)

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        other = int(self.variant.split()[-1]) - 1
        gained = ca.SX.zeros(elongation.shape[0])
        gained[self.leg] = theta[0] * force[other]
        if self.variant.startswith("shared"):
            gained[other] = theta[0] * force[self.leg]
        return elongation + gained, state

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        v = values["coupling_m_per_N"]
        other = " ".join(self.variant.split()[-2:])
        return (
            f"The force of {other} also deflects {self.component}: {1e9 * v[0]:.3g} ({1e9 * v[1]:.3g} to "
            f"{1e9 * v[2]:.3g}) nm per newton."
        )
