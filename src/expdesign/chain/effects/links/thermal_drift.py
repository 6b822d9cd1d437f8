"""An arm warms up: links grow and joints shift, whatever the load, relative to the first row of the series."""

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.arm import ArmEffect, arm_of, link_span, long_links
from expdesign.chain.components import each_joint, turning
from expdesign.chain.effect import Parameter
from expdesign.chain.effects.environment.thermal_drift import varies
from expdesign.chain.row import Row
from expdesign.recordings.recordings import LoadedPoints
from expdesign.robots.robot import Robot


class ArmThermalDrift(ArmEffect):
    """Joint k: Δq gains rate·ΔT (variant empty), rate·t (`time`) or drift·(e^(−t₀/τ) − e^(−t/τ)) (`warm-up`, time since
    the first row of all). Link k: its far end moves away from its start by the strain α·ΔT or rate·t.
    """

    physics = "thermal_drift"

    @classmethod
    def places(cls, robot: Robot, points: LoadedPoints) -> list[tuple[str, str]]:
        joints, links = each_joint(robot), long_links(robot)
        places: list[tuple[str, str]] = []
        if varies(points.temperature) or varies(points.leg_temperature):
            places += [(component, "") for component in (*joints, *links)]
        if points.time is not None and np.any(np.diff(points.time) > 0.0):
            places += [(component, "time") for component in (*joints, *links)]
            places += [(joint, "warm-up") for joint in joints]
        return places

    def describe(self) -> tuple[Parameter, ...]:
        unit, scale = ("per_s", 1e-8) if self.variant == "time" else ("per_K", 1e-6)
        if self.component.startswith("link"):
            return (Parameter(f"alpha_{unit}" if unit == "per_K" else "rate_per_s", scale, low=-1e-2, high=1e-2),)
        motion = "rad" if turning(self.robot, self.legs) else "m"
        if self.variant == "warm-up":
            tau = Parameter("tau_s", 1000.0, neutral=1000.0, low=1.0, high=1e6, shape=True)
            return (Parameter(f"drift_{motion}", 1e-5, low=-0.1, high=0.1), tau)
        return (Parameter(f"drift_{motion}_{unit}", scale, low=-1e-2, high=1e-2),)

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        if self.variant != "warm-up" or points.time is None:
            return [self.neutral()]
        return [np.array([0.0, tau]) for tau in np.geomspace(0.05, 1.5, 4) * max(float(np.ptp(points.time)), 1.0)]

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        if self.component.startswith("link"):
            return elongation, state
        if self.variant == "warm-up":
            driver = ca.exp(-(row.clock - row.elapsed) / theta[1]) - ca.exp(-row.clock / theta[1])
        else:
            driver = row.elapsed if self.variant == "time" else row.warming[self.leg]
        gained = ca.SX.zeros(elongation.shape[0])
        gained[self.leg] = theta[0] * driver
        return elongation + gained, state

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        if not self.component.startswith("link"):
            return deflection
        start, end = link_span(arm_of(self.robot), row.pose, self.leg)
        driver = row.elapsed if self.variant == "time" else row.warming[self.leg]
        return deflection + ca.vertcat(theta[0] * driver * (end - start), ca.SX.zeros(3))

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        name, value = next(iter(values.items()))
        size = f"{1e6 * value[0]:.3g} ({1e6 * value[1]:.3g} to {1e6 * value[2]:.3g})"
        if self.component.startswith("link"):
            per = "second" if name.endswith("_s") else "kelvin"
            return f"{self.component.capitalize()} grows: {size} µm per metre and {per}."
        unit = "µrad" if "rad" in name else "µm"
        if self.variant == "warm-up":
            return f"{self.component.capitalize()} shifts by {size} {unit} as it warms up ({values['tau_s'][0]:.3g} s)."
        per = "second" if name.endswith("_s") else "kelvin"
        return f"{self.component.capitalize()} shifts by {size} {unit} per {per}."
