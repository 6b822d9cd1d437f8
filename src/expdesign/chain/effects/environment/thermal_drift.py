"""What drifts with temperature or time: legs, the reading, and the joints and links of an arm."""

from dataclasses import replace
from functools import partial
from typing import ClassVar

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import (
    ENVIRONMENT,
    Component,
    Part,
    at_tip,
    each_joint,
    legs_and_all,
    link_span,
    long_links,
)
from expdesign.chain.declaration import IN_1000_S, Beyond, Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter, Shows, Values, When
from expdesign.chain.form import Acting, Form
from expdesign.chain.recordings.recordings import DEFLECTIONS, POSES, POSITIONS, LoadedPoints, Measurand
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot

_TIME = "time"
"""Variant of what follows time, not the temperature."""
_WARM_UP = "warm-up"
_CONSTANTS = np.geomspace(0.05, 1.5, 4)
"""Constants of warming up from which a search starts, of the time or the number of rows recorded."""


def _driver(row: Row, warming: ca.SX, *, time: bool) -> ca.SX:
    """What drives: time (s), or how much it has warmed (K), since the first row of the series."""
    return row.elapsed if time else warming


def _shifts(at: Acting, theta: ca.SX, *, time: bool = False) -> tuple[ca.SX, ca.SX]:
    return theta[0] * _driver(at.row, at.row.warming[at.index], time=time), at.state


def _grows(at: Acting, theta: ca.SX, *, time: bool = False) -> tuple[ca.SX, ca.SX]:
    return _shifts(at, theta * at.place, time=time)


def _warm_up(at: Acting, theta: ca.SX, *, by_rows: bool = False) -> tuple[ca.SX, ca.SX]:
    """Δq gains drift·(e^(−t₀/τ) − e^(−t/τ)), since the first row of all; t₀ is that of the series' first row.

    In recordings without time t counts rows (`by_rows`); positions are relative to no row, and t₀ is 0.
    """
    row = at.row
    before, now = (row.reference, row.number) if by_rows else (row.clock - row.elapsed, row.clock)
    return theta[0] * (ca.exp(-before / theta[1]) - ca.exp(-now / theta[1])), at.state


def _seen_drivers(robot: Robot, points: LoadedPoints) -> Shows:
    """Temperature and time show as far as they were recorded and changed."""
    temperatures = [each for each in (points.temperature, points.leg_temperature) if each is not None]
    warmed = any(np.any(np.ptp(each, axis=0) > 0.0) for each in temperatures)
    # Links have no time constant of their own.
    return lambda component, form: (
        not (component.part is Part.LINK and str(form) == _WARM_UP) and (points.timed if str(form) else warmed)
    )


class ThermalDrift(Effect):
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
    forms: ClassVar[tuple[Variant, ...]] = (Form(_grows), Form(partial(_grows, time=True), _TIME))
    shows = _seen_drivers

    @property
    def of_time(self) -> bool:
        """Whether it follows time, not the temperature."""
        return str(self.variant) == _TIME

    @classmethod
    def port_at(cls, component: Component) -> str:
        return "environment" if component == ENVIRONMENT else cls.declared.port

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        # An angle does not grow with temperature.
        growing = legs_and_all(robot) if set(robot.units) == {"m"} else []
        return [*growing, ENVIRONMENT]

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        return sorted(super().shown(robot, points), key=lambda place: cls.forms.index(place[1]))

    def describe(self) -> tuple[Parameter, ...]:
        unit, scale = ("per_s", 1e-9) if self.of_time else ("per_K", 1e-6)
        if self.component == ENVIRONMENT:
            names = self.robot.coordinates.deflection
            return tuple(Parameter(f"{name}_{unit}", scale, low=-1e-2, high=1e-2) for name in names)
        # Rubber grows by 2e-4 per kelvin.
        return (Parameter("alpha_per_K" if unit == "per_K" else "rate_per_s", scale, low=-1e-3, high=1e-3),)

    def reading(self, reading: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        if self.component != ENVIRONMENT:
            return reading
        return reading + theta * _driver(row, ca.sum1(row.warming) / row.warming.shape[0], time=self.of_time)

    def sentence(self, values: Values) -> str:
        cause, per = ("time", "second") if self.of_time else ("temperature", "kelvin")
        if self.component == ENVIRONMENT:
            return f"The reading drifts with {cause}, whatever the load: instrument or stand."
        return self.said(f"{{subject}} grow{{s}} with {cause}: {{first:1e6 .3g}} µm per metre and {per}.", values)


class ArmThermalDrift(ThermalDrift):
    """An arm warms up: links grow and joints shift, whatever the load, relative to the first row of the series.

    Joint k: Δq gains rate·ΔT (variant empty), rate·t (`time`) or that of an exponential (`warm-up`, time since the
    first row of all). Link k: its far end moves away from its start by the strain α·ΔT or rate·t.
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
    forms = (
        Form(_shifts),
        Form(partial(_shifts, time=True), _TIME),
        Form(
            _warm_up,
            _WARM_UP,
            parameters=(
                Parameter("drift_{motion}", 1e-5, low=-0.1, high=0.1),
                Parameter("tau_s", 1000.0, neutral=1000.0, low=1.0, high=1e6, shape=True),
            ),
            says="{subject} shifts by {first:1e6 .3g} µ{motion} as it warms up ({tau_s.best:.3g} s).",
            called="exponential",
            beyond=Beyond.GOES_ON,
        ),
    )

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [*each_joint(robot), *long_links(robot)]

    def describe(self) -> tuple[Parameter, ...]:
        if str(self.variant) == _WARM_UP:
            if self.component.part is Part.LINK:
                raise ValueError(f"`{self.component}` has no variant `{self.variant}`")
            return Effect.describe(self)
        unit, scale = ("per_s", 1e-8) if self.of_time else ("per_K", 1e-6)
        name = f"drift_{{motion}}_{unit}"
        if self.component.part is Part.LINK:
            name = "rate_per_s" if self.of_time else "alpha_per_K"
        return self.described([Parameter(name, scale, low=-1e-2, high=1e-2)])

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        if len(self.parameters) == 1 or points.time is None:
            return [self.neutral()]
        return [np.array([0.0, tau]) for tau in _CONSTANTS * max(float(np.ptp(points.time)), 1.0)]

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        if self.component.part is not Part.LINK:
            return deflection
        start, end = link_span(self.robot, row.pose, self.component.index)
        grown = theta[0] * _driver(row, row.warming[self.component.index], time=self.of_time) * (end - start)
        return deflection + at_tip(self.robot, self.component.index, grown, ca.SX.zeros(3), row, end)

    def sentence(self, values: Values) -> str:
        if len(values) > 1:
            return Effect.sentence(self, values)
        per = "second" if self.of_time else "kelvin"
        if self.component.part is Part.LINK:
            return self.said(f"{{subject}} grows: {{first:1e6 .3g}} µm per metre and {per}.", values)
        return self.said(f"{{subject}} shifts by {{first:1e6 .3g}} µ{{motion}} per {per}.", values)


FEWEST = 10
"""Rows below which a slow drift is not looked for."""


class WarmUpByRows(Effect):
    """A joint shifts as the machine warms up, in recordings without time: along `sequence`, one row like the next.

    Δq gains drift·(e^(−n₀/ν) − e^(−n/ν)), n rows after the first of all. Deflections are relative to the first row of
    their series, which had warmed up already (n₀ is its number); positions are not, and n₀ is 0.
    """

    identifier = "joints.warm_up_by_rows"
    physics = "thermal_drift"
    declared = replace(ArmThermalDrift.declared, form="exponential", inputs=(Input.TIME,), beyond=Beyond.GOES_ON)
    at = each_joint
    when: ClassVar[When] = lambda robot, points: not points.timed and len(points) >= FEWEST
    forms = (Form(partial(_warm_up, by_rows=True), "warm-up along sequence"),)
    quantities = (
        Parameter("drift_{motion}", 1e-5, low=-0.1, high=0.1),
        Parameter("constant_rows", 50.0, neutral=50.0, low=0.5, high=1e4, shape=True),
    )
    says = (
        "{subject} shifts by {drift:1e6 .3g} µ{motion} in the order of the rows, as by warming up (constant: "
        "{constant_rows.best:.3g} rows)."
    )

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        return [np.array([0.0, constant]) for constant in np.minimum(_CONSTANTS * len(points), 1e4)]
