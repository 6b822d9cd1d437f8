"""A deflection that follows temperature or time, not load."""

from enum import StrEnum

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import ENVIRONMENT, Component, legs_and_all
from expdesign.chain.declaration import IN_1000_S, Beyond, Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.recordings.recordings import DEFLECTIONS, LoadedPoints
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


def varies(temperature: FloatArray | None) -> bool:
    """Whether temperatures were recorded and changed."""
    return temperature is not None and bool(np.any(np.ptp(temperature, axis=0) > 0.0))


class Driver(StrEnum):
    """With what something drifts."""

    TEMPERATURE = ""
    TIME = "time"
    WARM_UP = "warm-up"


def seen_drivers(points: LoadedPoints) -> list[Driver]:
    """Temperature and time, as far as they were recorded and changed."""
    warmed = varies(points.temperature) or varies(points.leg_temperature)
    lasted = points.time is not None and bool(np.any(np.diff(points.time) > 0.0))
    return [driver for driver, seen in ((Driver.TEMPERATURE, warmed), (Driver.TIME, lasted)) if seen]


class ThermalDrift(Effect):
    """Legs: Δq gains α·q·ΔT (variant empty) or rate·q·t (`time`). `environment`: the reading gains a constant times
    ΔT or t on every axis, as a drifting instrument or stand does. All relative to the first row of the series.
    """

    physics = "thermal_drift"
    declared = Declaration(
        left_out="motion with temperature or time, whatever the load",
        phrase="thermal drift of {component}",
        usually="heat, and stands that settle",
        port="actuators",
        laws=("offset", "drift"),
        inputs=(Input.TIME, Input.TEMPERATURE),
        beyond=Beyond.HOLDS,
        sizes=(
            Size("alpha_per_K", 1.2e-5, "EN 1993-1-1:2005, 3.2.6: steel, 12e-6 per kelvin"),
            Size("rate_per_s", 1.2e-8, "assumed: steel that warms by 1 K in 1000 s"),
            Size("d?_m_per_K", 1e-6, "assumed: a stand of 0.1 m of steel"),
            Size("dr?_rad_per_K", 1e-6, "assumed: 1 µm over 1 m"),
            Size("d*_per_s", 1e-9, IN_1000_S),
        ),
    )
    measurands = (DEFLECTIONS,)

    @property
    def acts_at(self) -> str:
        return "environment" if self.component == ENVIRONMENT else self.declared.port

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        # An angle does not grow with temperature.
        growing = legs_and_all(robot) if set(robot.units) == {"m"} else []
        return [*growing, ENVIRONMENT]

    @classmethod
    def variants(cls, robot: Robot) -> list[Variant]:
        return [Driver.TEMPERATURE, Driver.TIME]

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        return [(component, driver) for driver in seen_drivers(points) for component in cls.components(robot)]

    def describe(self) -> tuple[Parameter, ...]:
        unit, scale = ("per_s", 1e-9) if self.variant is Driver.TIME else ("per_K", 1e-6)
        if self.component == ENVIRONMENT:
            coordinates = self.robot.coordinates
            return tuple(
                Parameter(f"{name.rsplit('_', 1)[0]}_{name.rsplit('_', 1)[1]}_{unit}", scale, low=-1e-2, high=1e-2)
                for name in coordinates.deflection
            )
        # Rubber grows by 2e-4 per kelvin.
        return (Parameter("alpha_per_K" if unit == "per_K" else "rate_per_s", scale, low=-1e-3, high=1e-3),)

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        if self.component == ENVIRONMENT:
            return elongation, state
        gained = ca.SX.zeros(elongation.shape[0])
        for leg in self.actuators:
            driver = row.elapsed if self.variant is Driver.TIME else row.warming[leg]
            gained[leg] = theta[0] * row.lengths[leg] * driver
        return elongation + gained, state

    def reading(self, reading: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        if self.component != ENVIRONMENT:
            return reading
        driver = row.elapsed if self.variant is Driver.TIME else ca.sum1(row.warming) / row.warming.shape[0]
        return reading + theta * driver

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        cause = "time" if self.variant is Driver.TIME else "temperature"
        if self.component == ENVIRONMENT:
            return f"The reading drifts with {cause}, whatever the load: instrument or stand."
        name, value = next(iter(values.items()))
        verb = "grow" if self.component.several else "grows"
        return (
            f"{self.subject} {verb} with {cause}: {1e6 * value[0]:.3g} ({1e6 * value[1]:.3g} to "
            f"{1e6 * value[2]:.3g}) µm per metre and {'second' if name.endswith('_s') else 'kelvin'}."
        )
