"""A body's support yields: rotation under moment, about the body's own origin or about a centre that is found.

A body's support is stiffer or softer under larger loads, or part of it lifts off.
"""

from collections.abc import Hashable
from dataclasses import dataclass
from enum import StrEnum

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import BASE, Component, symmetric
from expdesign.chain.declaration import TEN_PERCENT, Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.chain.support import (
    Drive,
    Over,
    drive_load,
    drive_values,
    drives,
    ending,
    measured_axes,
    over_pose,
    powers,
    split_over,
    twist_of,
    unit_of,
    whole_load,
    with_powers,
)
from expdesign.mechanics.robots.robot import Robot

_AXES = ("rx", "ry", "rz")
_PAIRS = ((0, 1), (0, 2), (1, 2))
_FARTHEST = 50.0
"""m; a centre of rotation farther away than this is a translation."""


class SupportForm(StrEnum):
    """Springs about the axes of O, about any axes through the origin of P, or about a point that is found."""

    AXES = "axes"
    ROTATION = "rotation"
    CENTRE = "centre"


@dataclass(frozen=True)
class Springs:
    """The form, and the range of a pose coordinate over which the compliance is a parabola."""

    form: SupportForm
    over: Over | None = None

    def __str__(self) -> str:
        return f"{self.form}{ending(self.over)}"


class SupportCompliance(Effect):
    """ω = C·M with M the moment about the centre of rotation, which is the origin of P or is found.

    Variants: `axes` (C diagonal: springs about x, y and z), `rotation` (C symmetric: springs about any axes), either
    of them ` over` a pose coordinate that varies (a column yields more the farther it is drawn out: C is a parabola in
    that coordinate), and `centre` (`rotation` about a point fixed to the ground, which moves P as well as turning it).
    """

    identifier = "support.compliance"
    physics = "base_compliance"
    declared = Declaration(
        left_out="compliance of a body's support",
        phrase="a soft base",
        usually="stands, floors and bolted feet",
        port="supports",
        laws=("compliance",),
        inputs=(Input.FORCE, Input.PLACE),
        sizes=(Size("compliance_*", 0.1, TEN_PERCENT, "pose compliance"),),
    )

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [BASE] if robot.on_support else []

    @classmethod
    def variant_from_text(cls, robot: Robot, text: str) -> Variant:
        form, over = split_over(text)
        return Springs(SupportForm(form), over)

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        if not robot.on_support:
            return []
        found = [Springs(SupportForm.AXES), Springs(SupportForm.ROTATION)]
        if measured_axes(points) & {0, 1, 2} or np.ptp(points.wrenches[:, :3], axis=0).any():
            # Pure moments and rotations say nothing of where a body turns.
            found.append(Springs(SupportForm.CENTRE))
        for over in over_pose(points, robot.configuration):
            found += [Springs(SupportForm.AXES, over), Springs(SupportForm.ROTATION, over)]
        return [(BASE, springs) for springs in found]

    def describe(self) -> tuple[Parameter, ...]:
        diagonal = [Parameter(f"compliance_{a}_{a}_rad_per_Nm", 1e-6, low=0.0) for a in _AXES]
        upper = [Parameter(f"compliance_{_AXES[i]}_{_AXES[j]}_rad_per_Nm", 1e-6) for i, j in _PAIRS]
        chosen = tuple(diagonal if self.variant.form is SupportForm.AXES else diagonal + upper)
        if self.variant.form is SupportForm.CENTRE:
            return chosen + tuple(
                Parameter(f"centre_{axis}_m", 1.0, neutral=0.0, low=-_FARTHEST, high=_FARTHEST, shape=True)
                for axis in "xyz"
            )
        return with_powers(chosen, self.variant.over)

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        if self.variant.form is not SupportForm.CENTRE:
            return [self.neutral()]
        position = self.robot.position(points.configurations).mean(axis=0)
        # On the ground below the body, at its own height, and far below.
        heights = (position[2], 0.0, position[2] - 3.0)
        return [np.concatenate([np.zeros(6), [position[0], position[1], height]]) for height in heights]

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        if self.variant.form is SupportForm.CENTRE:
            arm = row.position - theta[6:9]
            turn = symmetric(theta[:6], 3) @ (wrench[3:] + ca.cross(arm, wrench[:3]))
            return deflection + row.rates @ ca.vertcat(ca.cross(turn, arm), turn)
        width = 3 if self.variant.form is SupportForm.AXES else 6
        turn = ca.SX.zeros(3)
        for i, factor in enumerate(powers(self.variant.over, row, self.robot.configuration)):
            turn += factor * (symmetric(theta[width * i : width * (i + 1)], 3) @ wrench[3:])
        return deflection + row.rates @ ca.vertcat(ca.SX.zeros(3), turn)

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        known = {axis: values[f"compliance_{axis}_{axis}_rad_per_Nm"] for axis in _AXES}
        listed = ", ".join(
            f"{1e6 * v[0]:.3g} ({1e6 * v[1]:.3g} to {1e6 * v[2]:.3g}) µrad per N·m about {axis[1]}"
            for axis, v in known.items()
            if abs(v[2]) < 1e299
        )
        text = f"What the body stands on yields: {listed or 'by an amount that is hardly known'}"
        if self.variant.over is not None:
            text += f" {self.variant.over.sentence}"
        if self.variant.form is SupportForm.CENTRE:
            x, y, z = (values[f"centre_{axis}_m"][0] for axis in "xyz")
            text += f"; it turns about ({x:.2f}, {y:.2f}, {z:.2f}) m in O"
        return text + "."


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

    identifier = "support.nonlinearity"
    physics = "base_compliance"
    declared = Declaration(
        left_out="compliance of a body's support",
        phrase="a soft base",
        usually="feet that lift off, rubber",
        port="supports",
        laws=("force law",),
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
    def form_name(self) -> str:
        return str(self.variant.bend)

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
