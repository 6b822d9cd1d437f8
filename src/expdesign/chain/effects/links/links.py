"""Links of an arm: they bend, weigh what the URDF does not say, and grow as they warm up, as joints shift."""

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.actuator import Acting, ActuatorEffect
from expdesign.chain.component import (
    Component,
    Part,
    at_tip,
    each_joint,
    heavy_links,
    link_span,
    long_links,
    moment_at,
    with_links_beyond,
)
from expdesign.chain.declaration import IN_1000_S, TEN_PERCENT, Beyond, Declaration, Input, Size, Variant
from expdesign.chain.effect import Parameter, Values
from expdesign.chain.effects.environment.thermal_drift import Driver, seen_drivers
from expdesign.chain.recordings.recordings import POSITIONS, LoadedPoints
from expdesign.chain.row import Row
from expdesign.chain.tabulated import TabulatedEffect
from expdesign.mechanics.robots.robot import Robot


class LinkCompliance(TabulatedEffect):
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


class LinkMassError(TabulatedEffect):
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


class ArmThermalDrift(ActuatorEffect):
    """An arm warms up: links grow and joints shift, whatever the load, relative to the first row of the series.

    Joint k: Δq gains rate·ΔT (variant empty), rate·t (`time`) or drift·(e^(−t₀/τ) − e^(−t/τ)) (`warm-up`, time since
    the first row of all). Link k: its far end moves away from its start by the strain α·ΔT or rate·t.
    """

    identifier = "links.thermal_drift"
    physics = "thermal_drift"
    declared = Declaration(
        left_out="motion with temperature or time, whatever the load",
        phrase="thermal drift of {component}",
        usually="motors and gears that warm up",
        port="actuators",
        laws=("offset",),
        inputs=(Input.TIME, Input.TEMPERATURE),
        beyond=Beyond.HOLDS,
        sizes=(
            Size("alpha_per_K", 1.2e-5, "EN 1993-1-1:2005, 3.2.6: steel, 12e-6 per kelvin"),
            Size("rate_per_s", 1.2e-8, "assumed: steel that warms by 1 K in 1000 s"),
            Size("drift_m_per_K", 5e-6, "assumed: a linear axis of 0.4 m of steel"),
            Size("drift_m_per_s", 5e-9, IN_1000_S),
            Size("drift_m", 5e-5, "assumed: warming up by 10 K"),
            Size("drift_rad_per_K", 1e-5, "assumed: a joint's housing"),
            Size("drift_rad_per_s", 1e-8, IN_1000_S),
            Size("drift_rad", 1e-4, "assumed: warming up by 10 K"),
        ),
    )
    forms = tuple(Driver)

    @property
    def form_name(self) -> str:
        return "exponential" if self.variant is Driver.WARM_UP else self.declared.form

    @property
    def beyond(self) -> Beyond:
        return Beyond.GOES_ON if self.variant is Driver.WARM_UP else self.declared.beyond

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [*each_joint(robot), *long_links(robot)]

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        seen = seen_drivers(points)
        places: list[tuple[Component, Variant]] = [
            (component, driver) for driver in seen for component in cls.components(robot)
        ]
        return places + [(joint, Driver.WARM_UP) for joint in each_joint(robot) if Driver.TIME in seen]

    def describe(self) -> tuple[Parameter, ...]:
        unit, scale = ("per_s", 1e-8) if self.variant is Driver.TIME else ("per_K", 1e-6)
        if self.component.part is Part.LINK:
            return (Parameter(f"alpha_{unit}" if unit == "per_K" else "rate_per_s", scale, low=-1e-2, high=1e-2),)
        if self.variant is not Driver.WARM_UP:
            return self.described([Parameter(f"drift_{{motion}}_{unit}", scale, low=-1e-2, high=1e-2)])
        drift = Parameter("drift_{motion}", 1e-5, low=-0.1, high=0.1)
        return self.described([drift, Parameter("tau_s", 1000.0, neutral=1000.0, low=1.0, high=1e6, shape=True)])

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        if self.variant is not Driver.WARM_UP or points.time is None:
            return [self.neutral()]
        return [np.array([0.0, tau]) for tau in np.geomspace(0.05, 1.5, 4) * max(float(np.ptp(points.time)), 1.0)]

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        none = self.component.part is Part.LINK
        return (elongation, state) if none else super().actuator(elongation, force, compliance, row, state, theta)

    def gain(self, at: Acting, row: Row, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
        if self.variant is Driver.WARM_UP:
            return theta[0] * (ca.exp(-(row.clock - row.elapsed) / theta[1]) - ca.exp(-row.clock / theta[1])), at.state
        return theta[0] * (row.elapsed if self.variant is Driver.TIME else row.warming[at.index]), at.state

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        if self.component.part is not Part.LINK:
            return deflection
        start, end = link_span(self.robot, row.pose, self.component.index)
        driver = row.elapsed if self.variant is Driver.TIME else row.warming[self.component.index]
        grown = theta[0] * driver * (end - start)
        return deflection + at_tip(self.robot, self.component.index, grown, ca.SX.zeros(3), row, end)

    def sentence(self, values: Values) -> str:
        per = "second" if self.variant is Driver.TIME else "kelvin"
        if self.component.part is Part.LINK:
            return self.said(f"{{subject}} grows: {{first:1e6 .3g}} µm per metre and {per}.", values)
        how = "as it warms up ({tau_s.best:.3g} s)" if self.variant is Driver.WARM_UP else f"per {per}"
        return self.said(f"{{subject}} shifts by {{first:1e6 .3g}} µ{{motion}} {how}.", values)
