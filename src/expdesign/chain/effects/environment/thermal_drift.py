"""What drifts with temperature or time: legs, and the reading."""

from enum import StrEnum

import casadi as ca
import numpy as np

from expdesign.chain.actuator import Acting, ActuatorEffect
from expdesign.chain.component import ENVIRONMENT, Component, legs_and_all
from expdesign.chain.declaration import IN_1000_S, Beyond, Declaration, Input, Size, Variant
from expdesign.chain.effect import Parameter, Values
from expdesign.chain.recordings.recordings import DEFLECTIONS, LoadedPoints
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


class Driver(StrEnum):
    """With what something drifts."""

    TEMPERATURE = ""
    TIME = "time"
    WARM_UP = "warm-up"


def seen_drivers(points: LoadedPoints) -> list[Driver]:
    """Temperature and time, as far as they were recorded and changed."""
    temperatures = [each for each in (points.temperature, points.leg_temperature) if each is not None]
    warmed = any(np.any(np.ptp(each, axis=0) > 0.0) for each in temperatures)
    return [driver for driver, seen in ((Driver.TEMPERATURE, warmed), (Driver.TIME, points.timed)) if seen]


class ThermalDrift(ActuatorEffect):
    """A deflection that follows temperature or time, not load.

    Legs: Δq gains α·q·ΔT (variant empty) or rate·q·t (`time`). `environment`: the reading gains a constant times
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
    forms = (Driver.TEMPERATURE, Driver.TIME)

    @property
    def acts_at(self) -> str:
        return "environment" if self.component == ENVIRONMENT else self.declared.port

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        # An angle does not grow with temperature.
        growing = legs_and_all(robot) if set(robot.units) == {"m"} else []
        return [*growing, ENVIRONMENT]

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        return [(component, driver) for driver in seen_drivers(points) for component in cls.components(robot)]

    def describe(self) -> tuple[Parameter, ...]:
        unit, scale = ("per_s", 1e-9) if self.variant is Driver.TIME else ("per_K", 1e-6)
        if self.component == ENVIRONMENT:
            names = self.robot.coordinates.deflection
            return tuple(Parameter(f"{name}_{unit}", scale, low=-1e-2, high=1e-2) for name in names)
        # Rubber grows by 2e-4 per kelvin.
        return (Parameter("alpha_per_K" if unit == "per_K" else "rate_per_s", scale, low=-1e-3, high=1e-3),)

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        none = self.component == ENVIRONMENT
        return (elongation, state) if none else super().actuator(elongation, force, compliance, row, state, theta)

    def gain(self, at: Acting, row: Row, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
        driver = row.elapsed if self.variant is Driver.TIME else row.warming[at.index]
        return theta[0] * at.place * driver, at.state

    def reading(self, reading: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        if self.component != ENVIRONMENT:
            return reading
        driver = row.elapsed if self.variant is Driver.TIME else ca.sum1(row.warming) / row.warming.shape[0]
        return reading + theta * driver

    def sentence(self, values: Values) -> str:
        cause, per = ("time", "second") if self.variant is Driver.TIME else ("temperature", "kelvin")
        if self.component == ENVIRONMENT:
            return f"The reading drifts with {cause}, whatever the load: instrument or stand."
        return self.said(f"{{subject}} grow{{s}} with {cause}: {{first:1e6 .3g}} µm per metre and {per}.", values)
