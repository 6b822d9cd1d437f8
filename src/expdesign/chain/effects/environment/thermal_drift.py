"""What drifts with temperature or time: legs, the reading, and the joints and links of an arm."""

from dataclasses import replace
from enum import StrEnum
from typing import ClassVar

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.actuator import Acting, ActuatorEffect
from expdesign.chain.component import (
    ACTUATORS,
    ENVIRONMENT,
    Component,
    Part,
    at_tip,
    each_joint,
    legs_and_all,
    link_span,
    long_links,
)
from expdesign.chain.declaration import IN_1000_S, Beyond, Declaration, Input, Named, Size, Variant
from expdesign.chain.effect import Parameter, Values, When
from expdesign.chain.recordings.recordings import DEFLECTIONS, POSES, POSITIONS, LoadedPoints, Measurand
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
    measurands: ClassVar[tuple[Measurand, ...]] = (DEFLECTIONS,)
    forms: ClassVar[tuple[Variant, ...]] = (Driver.TEMPERATURE, Driver.TIME)

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

    def driver(self, row: Row, warming: ca.SX) -> ca.SX:
        """What drives: time (s), or how much it has warmed (K), since the first row of the series."""
        return row.elapsed if self.variant is Driver.TIME else warming

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        if self.component.part not in ACTUATORS:
            return elongation, state
        return super().actuator(elongation, force, compliance, row, state, theta)

    def gain(self, at: Acting, row: Row, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
        return theta[0] * at.place * self.driver(row, row.warming[at.index]), at.state

    def reading(self, reading: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        if self.component != ENVIRONMENT:
            return reading
        return reading + theta * self.driver(row, ca.sum1(row.warming) / row.warming.shape[0])

    def sentence(self, values: Values) -> str:
        cause, per = ("time", "second") if self.variant is Driver.TIME else ("temperature", "kelvin")
        if self.component == ENVIRONMENT:
            return f"The reading drifts with {cause}, whatever the load: instrument or stand."
        return self.said(f"{{subject}} grow{{s}} with {cause}: {{first:1e6 .3g}} µm per metre and {per}.", values)


class ArmThermalDrift(ThermalDrift):
    """An arm warms up: links grow and joints shift, whatever the load, relative to the first row of the series.

    Joint k: Δq gains rate·ΔT (variant empty), rate·t (`time`) or drift·(e^(−t₀/τ) − e^(−t/τ)) (`warm-up`, time since
    the first row of all). Link k: its far end moves away from its start by the strain α·ΔT or rate·t.
    """

    identifier = "links.thermal_drift"
    declared = replace(
        ThermalDrift.declared,
        usually="motors and gears that warm up",
        laws=("offset",),
        sizes=(
            *ThermalDrift.declared.sizes[:2],
            Size("drift_m_per_K", 5e-6, "assumed: a linear axis of 0.4 m of steel"),
            Size("drift_m_per_s", 5e-9, IN_1000_S),
            Size("drift_m", 5e-5, "assumed: warming up by 10 K"),
            Size("drift_rad_per_K", 1e-5, "assumed: a joint's housing"),
            Size("drift_rad_per_s", 1e-8, IN_1000_S),
            Size("drift_rad", 1e-4, "assumed: warming up by 10 K"),
        ),
    )
    measurands = (DEFLECTIONS, POSITIONS, POSES)
    changes_reading = False
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
        warm_up: list[tuple[Component, Variant]] = [(joint, Driver.WARM_UP) for joint in each_joint(robot)]
        return super().shown(robot, points) + (warm_up if points.timed else [])

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

    def gain(self, at: Acting, row: Row, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
        if self.variant is Driver.WARM_UP:
            return theta[0] * (ca.exp(-(row.clock - row.elapsed) / theta[1]) - ca.exp(-row.clock / theta[1])), at.state
        return theta[0] * self.driver(row, row.warming[at.index]), at.state

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        if self.component.part is not Part.LINK:
            return deflection
        start, end = link_span(self.robot, row.pose, self.component.index)
        grown = theta[0] * self.driver(row, row.warming[self.component.index]) * (end - start)
        return deflection + at_tip(self.robot, self.component.index, grown, ca.SX.zeros(3), row, end)

    def sentence(self, values: Values) -> str:
        per = "second" if self.variant is Driver.TIME else "kelvin"
        if self.component.part is Part.LINK:
            return self.said(f"{{subject}} grows: {{first:1e6 .3g}} µm per metre and {per}.", values)
        how = "as it warms up ({tau_s.best:.3g} s)" if self.variant is Driver.WARM_UP else f"per {per}"
        return self.said(f"{{subject}} shifts by {{first:1e6 .3g}} µ{{motion}} {how}.", values)


FEWEST = 10
"""Rows below which a slow drift is not looked for."""


class WarmUpByRows(ActuatorEffect):
    """A joint shifts as the machine warms up, in recordings without time: along `sequence`, one row like the next.

    Δq gains drift·(e^(−n₀/ν) − e^(−n/ν)), n rows after the first of all. Deflections are relative to the first row of
    their series, which had warmed up already (n₀ is its number); positions are not, and n₀ is 0.
    """

    identifier = "joints.warm_up_by_rows"
    physics = "thermal_drift"
    declared = replace(ArmThermalDrift.declared, form="exponential", inputs=(Input.TIME,), beyond=Beyond.GOES_ON)
    at = each_joint
    when: ClassVar[When] = lambda robot, points: not points.timed and len(points) >= FEWEST
    forms = (Named("warm-up along sequence"),)
    quantities = (
        Parameter("drift_{motion}", 1e-5, low=-0.1, high=0.1),
        Parameter("constant_rows", 50.0, neutral=50.0, low=0.5, high=1e6, shape=True),
    )
    says = (
        "{subject} shifts by {drift:1e6 .3g} µ{motion} in the order of the rows, as by warming up (constant: "
        "{constant_rows.best:.3g} rows)."
    )

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        return [np.array([0.0, constant]) for constant in np.geomspace(0.05, 1.5, 4) * len(points)]

    def gain(self, at: Acting, row: Row, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
        return theta[0] * (ca.exp(-row.reference / theta[1]) - ca.exp(-row.number / theta[1])), at.state
