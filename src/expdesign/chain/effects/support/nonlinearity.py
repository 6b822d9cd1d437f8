"""A body's support is stiffer or softer under larger loads, or part of it lifts off."""

from collections.abc import Hashable
from dataclasses import dataclass
from enum import StrEnum

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import BASE, Component
from expdesign.chain.declaration import Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.chain.support import Drive, drive_load, drive_values, drives, twist_of, unit_of, whole_load
from expdesign.mechanics.robots.robot import Robot

_AROUND = tuple(np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False))


class Bend(StrEnum):
    """How the support is not linear."""

    STIFFENING = "stiffening"
    LIFT_OFF = "lift-off"


@dataclass(frozen=True)
class ForceLaw:
    """How the support is not linear, and under which load."""

    bend: Bend
    drive: Drive

    def __str__(self) -> str:
        return f"{self.bend} {self.drive}"


class SupportNonlinearity(Effect):
    """Beyond a linear support. Variants, each with the direction of the load: `stiffening` (the motion gains a cubic of
    the whole load) and `lift-off` (beyond a load part of the support carries no more, and the rest yields further:
    hinge at that load). `lift-off oblique` finds the axis about which the body tips.
    """

    physics = "base_compliance"
    declared = Declaration(
        left_out="compliance of a body's support",
        phrase="a soft base",
        usually="feet that lift off, rubber",
        port="supports",
        inputs=(Input.FORCE,),
        sizes=(
            Size("beyond_*", 1e-7, "assumed: a foot that lifts, 0.1 µrad/(N·m)"),
            Size("cubic_*", 1e-6, "assumed: rubber feet, 1 µm under 100 N, 1 µrad under 100 N·m"),
        ),
    )
    builds_on = "base_compliance"

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [BASE] if robot.on_support else []

    @classmethod
    def variants(cls, robot: Robot) -> list[Variant]:
        return [ForceLaw(bend, drive) for bend in Bend for drive in Drive]

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        if not robot.on_support:
            return []
        found = [ForceLaw(Bend.STIFFENING, drive) for drive in drives(points)]
        found += [ForceLaw(Bend.LIFT_OFF, drive) for drive in drives(points, oblique=True)]
        return [(BASE, law) for law in found]

    @property
    def drive(self) -> Drive:
        """Direction of the load."""
        drive: Drive = self.variant.drive
        return drive

    @property
    def slot(self) -> tuple[Hashable, ...]:
        return self.physics, self.component, self.variant

    def describe(self) -> tuple[Parameter, ...]:
        force, motion = unit_of(self.drive)
        if self.variant.bend is Bend.STIFFENING:
            return (Parameter(f"cubic_{motion}_at_100_{force}", 1e-6),)
        hinge = Parameter(f"lift_off_{force}", 10.0, low=-1e6, high=1e6, shape=True)
        if self.drive is Drive.OBLIQUE:
            return (
                Parameter("beyond_rx_rad_per_Nm", 1e-6),
                Parameter("beyond_ry_rad_per_Nm", 1e-6),
                hinge,
                Parameter("azimuth_rad", 1.0, low=-10.0, high=10.0, shape=True),
            )
        return (Parameter(f"beyond_{motion}_per_{force}", 1e-6), hinge)

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        if self.variant.bend is Bend.STIFFENING:
            return [self.neutral()]
        starts = []
        for azimuth in _AROUND if self.drive is Drive.OBLIQUE else (0.0,):
            for load in np.quantile(drive_values(self.drive, points.absolute, azimuth), (0.25, 0.5, 0.75)):
                starts.append(np.array([0.0, 0.0, load, azimuth] if self.drive is Drive.OBLIQUE else [0.0, load]))
        return starts

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        now, before = whole_load(wrench, row)
        if self.variant.bend is Bend.STIFFENING:
            amounts = theta[0] * sum(
                sign * (drive_load(self.drive, load) / 100.0) ** 3 for sign, load in ((1.0, now), (-1.0, before))
            )
            return deflection + row.rates @ twist_of(self.drive, amounts)
        azimuth = theta[3] if self.drive is Drive.OBLIQUE else 0.0
        hinge = theta[2] if self.drive is Drive.OBLIQUE else theta[1]
        beyond = ca.fmax(drive_load(self.drive, now, azimuth) - hinge, 0.0)
        beyond -= ca.fmax(drive_load(self.drive, before, azimuth) - hinge, 0.0)
        amounts = (theta[:2] if self.drive is Drive.OBLIQUE else theta[0]) * beyond
        return deflection + row.rates @ twist_of(self.drive, amounts)

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        force, _ = unit_of(self.drive)
        where = "about an oblique axis" if self.drive is Drive.OBLIQUE else self.drive
        if self.variant.bend is Bend.STIFFENING:
            value = next(iter(values.values()))[0]
            return f"The support {'softens' if value > 0.0 else 'stiffens'} with the load {where} (cubic)."
        at = values[f"lift_off_{force}"][0]
        unit = "N·m" if force == "Nm" else "N"
        return f"The support yields differently beyond {at:.3g} {unit} {where}, as where a foot lifts off."
