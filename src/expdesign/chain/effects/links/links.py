"""Links of an arm: they bend, weigh what the URDF does not say, and grow as they warm up, as joints shift."""

import casadi as ca

from expdesign.chain.component import (
    at_tip,
    heavy_links,
    link_span,
    long_links,
    moment_at,
    with_links_beyond,
)
from expdesign.chain.declaration import TEN_PERCENT, Declaration, Input, Size
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.recordings.recordings import POSITIONS
from expdesign.chain.row import Row


class LinkCompliance(Effect):
    """A link bends and twists as a beam that is clamped where it begins and carries what lies beyond its far end.

    With force f and moment M at the far end of a link of length L along d (Euler and Bernoulli; κ = L/EI, κ_t = L/GJ),

        turn of the end = κ·P·(M + L/2·d×f) + κ_t·d·dᵀM,   its motion = κ·(L/2·P·M + L²/3·d×f)×d,   P = I − d·dᵀ,

    κ being `bending_rad_per_Nm` and κ_t `torsion_rad_per_Nm`: turns of the link's end per moment there.
    """

    identifier = "links.compliance"
    physics = "link_compliance"
    declared = Declaration(
        left_out="bending of an arm's link",
        phrase="a soft {component}",
        usually="slender links",
        port="joints",
        inputs=(Input.FORCE, Input.PLACE),
        sizes=(Size("*_rad_per_Nm", 0.1, TEN_PERCENT, "actuator compliance"),),
    )

    at = long_links
    quantities = tuple(Parameter(f"{how}_rad_per_Nm", 1e-6, low=0.0, high=1.0) for how in ("bending", "torsion"))
    says = (
        "{subject} bends: its end turns by {bending_rad_per_Nm:1e6 .3g} µrad per N·m across it and "
        "{torsion_rad_per_Nm.best:1e6 .3g} about it."
    )

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


_SPREAD = 0.3
"""Standard deviation of a link's true mass about that of its CAD model, which lacks cables, covers and grease."""


class LinkMassError(Effect):
    """A link weighs something else than its URDF says (CAD masses without cables, covers or grease).

    `link k`, with what hangs on it, weighs 1 + `relative_mass_error` times as much as assumed. Own weight cancels from
    deflections, so that it shows in positions only, as a sag other than the assumed one.
    """

    identifier = "links.mass_error"
    physics = "payload_mass_error"
    declared = Declaration(
        left_out="error of a mass or of the scale of a wrench",
        phrase="masses that are not what was assumed",
        usually="cables, covers and grease that a CAD model lacks",
        port="actuators",
        inputs=(Input.PLACE,),
        sizes=(Size("relative_mass_error", _SPREAD, "assumed: what CAD models of links leave out"),),
    )
    measurands = (POSITIONS,)

    at = heavy_links
    quantities = (Parameter("relative_mass_error", 0.1, low=-0.9, high=3.0, spread=_SPREAD),)
    says = "{subject}, with what hangs on it, is {relative_mass_error:100 +.1f %} heavier than the URDF says."

    def own_weight_change(self, row: Row, theta: ca.SX) -> ca.SX:
        q = ca.SX.sym("q", len(self.robot.configuration))
        only = ca.SX([float(k == self.component.index) for k in range(len(self.robot.stiffness))])
        torque = self.robot.links.own_weight_expression(q, row.gravity, factors=only)
        return theta[0] * ca.substitute(torque, q, row.pose)
