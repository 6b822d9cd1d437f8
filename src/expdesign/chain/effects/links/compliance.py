"""A link bends and twists as a beam that is clamped where it begins and carries what lies beyond its far end.

With force f and moment M at the far end of a link of length L along d (Euler and Bernoulli; κ = L/EI, κ_t = L/GJ),

    turn of the end = κ·P·(M + L/2·d×f) + κ_t·d·dᵀM,   its motion = κ·(L/2·P·M + L²/3·d×f)×d,   P = I − d·dᵀ.
"""

from collections.abc import Sequence

import casadi as ca

from expdesign.chain.component import Component, at_tip, link_span, long_links, moment_at, with_links_beyond
from expdesign.chain.declaration import TEN_PERCENT, Declaration, Input, Size
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


class LinkCompliance(Effect):
    """`bending_rad_per_Nm` κ and `torsion_rad_per_Nm` κ_t: turns of the link's end per moment there."""

    physics = "link_compliance"
    declared = Declaration(
        left_out="bending of an arm's link",
        phrase="a soft {component}",
        usually="slender links",
        port="joints",
        inputs=(Input.FORCE, Input.PLACE),
        sizes=(Size("*_rad_per_Nm", 0.1, TEN_PERCENT, "actuator compliance"),),
    )

    @classmethod
    def components(cls, robot: Robot) -> Sequence[Component]:
        return long_links(robot)

    def describe(self) -> tuple[Parameter, ...]:
        return tuple(Parameter(f"{how}_rad_per_Nm", 1e-6, low=0.0, high=1.0) for how in ("bending", "torsion"))

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        start, end = link_span(self.robot, row.pose, self.component.index)
        length = ca.norm_2(end - start)
        along = (end - start) / length
        load = with_links_beyond(self.robot, wrench, row, self.component.number, own=False)
        moment, lever = moment_at(load, row, end), length * ca.cross(along, load[:3])
        twisting = along * ca.dot(along, moment)
        turn = theta[0] * (moment - twisting + lever / 2.0) + theta[1] * twisting
        moved = theta[0] * length * ca.cross((moment - twisting) / 2.0 + lever / 3.0, along)
        return deflection + at_tip(self.robot, self.component.index, moved, turn, row, end)

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        bend, twist = values["bending_rad_per_Nm"], values["torsion_rad_per_Nm"]
        return (
            f"{self.subject} bends: its end turns by {1e6 * bend[0]:.3g} ({1e6 * bend[1]:.3g} to "
            f"{1e6 * bend[2]:.3g}) µrad per N·m across it and {1e6 * twist[0]:.3g} about it."
        )
