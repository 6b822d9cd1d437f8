"""An arm warms up: links grow and joints shift, whatever the load, relative to the first row of the series."""

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import Component, Part, at_tip, each_joint, link_span, long_links, turning
from expdesign.chain.declaration import IN_1000_S, Beyond, Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.effects.environment.thermal_drift import Driver, seen_drivers
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


class ArmThermalDrift(Effect):
    """Joint k: Δq gains rate·ΔT (variant empty), rate·t (`time`) or drift·(e^(−t₀/τ) − e^(−t/τ)) (`warm-up`, time since
    the first row of all). Link k: its far end moves away from its start by the strain α·ΔT or rate·t.
    """

    physics = "thermal_drift"
    declared = Declaration(
        left_out="motion with temperature or time, whatever the load",
        phrase="thermal drift of {component}",
        usually="motors and gears that warm up",
        port="actuators",
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
        motion = "rad" if turning(self.robot, self.actuators) else "m"
        if self.variant is Driver.WARM_UP:
            tau = Parameter("tau_s", 1000.0, neutral=1000.0, low=1.0, high=1e6, shape=True)
            return (Parameter(f"drift_{motion}", 1e-5, low=-0.1, high=0.1), tau)
        return (Parameter(f"drift_{motion}_{unit}", scale, low=-1e-2, high=1e-2),)

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        if self.variant is not Driver.WARM_UP or points.time is None:
            return [self.neutral()]
        return [np.array([0.0, tau]) for tau in np.geomspace(0.05, 1.5, 4) * max(float(np.ptp(points.time)), 1.0)]

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        if self.component.part is Part.LINK:
            return elongation, state
        if self.variant is Driver.WARM_UP:
            driver = ca.exp(-(row.clock - row.elapsed) / theta[1]) - ca.exp(-row.clock / theta[1])
        else:
            driver = row.elapsed if self.variant is Driver.TIME else row.warming[self.component.index]
        gained = ca.SX.zeros(elongation.shape[0])
        gained[self.component.index] = theta[0] * driver
        return elongation + gained, state

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        if self.component.part is not Part.LINK:
            return deflection
        start, end = link_span(self.robot, row.pose, self.component.index)
        driver = row.elapsed if self.variant is Driver.TIME else row.warming[self.component.index]
        grown = theta[0] * driver * (end - start)
        return deflection + at_tip(self.robot, self.component.index, grown, ca.SX.zeros(3), row, end)

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        name, value = next(iter(values.items()))
        size = f"{1e6 * value[0]:.3g} ({1e6 * value[1]:.3g} to {1e6 * value[2]:.3g})"
        if self.component.part is Part.LINK:
            per = "second" if name.endswith("_s") else "kelvin"
            return f"{self.subject} grows: {size} µm per metre and {per}."
        unit = "µrad" if "rad" in name else "µm"
        if self.variant is Driver.WARM_UP:
            return f"{self.subject} shifts by {size} {unit} as it warms up ({values['tau_s'][0]:.3g} s)."
        per = "second" if name.endswith("_s") else "kelvin"
        return f"{self.subject} shifts by {size} {unit} per {per}."
