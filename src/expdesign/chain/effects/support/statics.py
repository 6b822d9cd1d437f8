"""What a body stands on does under the load of the moment: it yields, is not linear, and has play."""

from collections.abc import Hashable
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import ClassVar

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import BASE, Component, symmetric
from expdesign.chain.declaration import STRAIN_WAVE, TEN_PERCENT, Declaration, Input, Size, Variant
from expdesign.chain.effect import Parameter, Values, When
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.chain.support import (
    FARTHEST,
    Drive,
    Posed,
    SupportEffect,
    drive_load,
    drive_values,
    drives,
    measured_axes,
    over_pose,
    powers,
    taken_up,
    twist_of,
    whole_load,
    with_powers,
)
from expdesign.mechanics.robots.robot import Robot

AXES = ("rx", "ry", "rz")


def entries(name: str, scale: float, *, diagonal: bool = False) -> tuple[Parameter, ...]:
    """Entries of a symmetric rotational compliance: its diagonal, then its upper triangle by rows unless `diagonal`."""
    pairs = [(a, a) for a in AXES] + [(a, b) for i, a in enumerate(AXES) for b in AXES[i + 1 :] if not diagonal]
    return tuple(Parameter(f"{name}_{a}_{b}_rad_per_Nm", scale, low=0.0 if a == b else float("-inf")) for a, b in pairs)


class SupportForm(StrEnum):
    """Springs about the axes of O, about any axes through the origin of P, or about a point that is found."""

    AXES = "axes"
    ROTATION = "rotation"
    CENTRE = "centre"


class SupportCompliance(SupportEffect):
    """A body's support yields: ω = C·M with M the moment about the centre of rotation, the origin of P or found.

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
    forms = tuple(Posed(form) for form in SupportForm)
    together = False

    @classmethod
    def variant_from_text(cls, robot: Robot, text: str) -> Variant:
        return Posed.from_text(SupportForm, text)

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        found = [Posed(SupportForm.AXES), Posed(SupportForm.ROTATION)]
        if measured_axes(points) & {0, 1, 2} or np.ptp(points.wrenches[:, :3], axis=0).any():
            # Pure moments and rotations say nothing of where a body turns.
            found.append(Posed(SupportForm.CENTRE))
        for over in over_pose(points, robot.configuration):
            found += [Posed(SupportForm.AXES, over), Posed(SupportForm.ROTATION, over)]
        return [(BASE, springs) for springs in found]

    @property
    def units(self) -> tuple[str, str]:
        return "Nm", "rad"

    def describe(self) -> tuple[Parameter, ...]:
        chosen = entries("compliance", 1e-6, diagonal=self.variant.form is SupportForm.AXES)
        if self.variant.form is not SupportForm.CENTRE:
            return with_powers(chosen, self.variant.over)
        return chosen + tuple(
            Parameter(f"centre_{axis}_m", 1.0, neutral=0.0, low=-FARTHEST, high=FARTHEST, shape=True) for axis in "xyz"
        )

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

    def sentence(self, values: Values) -> str:
        names = {axis[1]: f"compliance_{axis}_{axis}_rad_per_Nm" for axis in AXES}
        known = [
            f"{{{name}:1e6 .3g}} µrad per N·m about {axis}"
            for axis, name in names.items()
            if abs(values[name][2]) < 1e299
        ]
        text = f"What the body stands on yields: {', '.join(known) or 'by an amount that is hardly known'}"
        if self.variant.over is not None:
            text += f" {self.variant.over.sentence}"
        if self.variant.form is SupportForm.CENTRE:
            text += "; it turns about ({centre_x_m.best:.2f}, {centre_y_m.best:.2f}, {centre_z_m.best:.2f}) m in O"
        return self.said(f"{text}.", values)


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


class SupportNonlinearity(SupportEffect):
    """A body's support is stiffer or softer under larger loads, or part of it lifts off: what is beyond a linear one.

    Variants, each with the direction of the load: `stiffening` (the motion gains a cubic of the whole load) and
    `lift-off` (beyond a load part of the support carries no more, and the rest yields further: hinge at that load).
    `lift-off oblique` finds the axis about which the body tips.
    """

    identifier = "support.nonlinearity"
    physics = "base_compliance"
    declared = replace(
        SupportCompliance.declared,
        usually="feet that lift off, rubber",
        laws=("force law",),
        inputs=(Input.FORCE,),
        sizes=(
            Size("beyond_*", 1e-7, "assumed: a foot that lifts, 0.1 µrad/(N·m)"),
            Size("cubic_*", 1e-6, "assumed: rubber feet, 1 µm under 100 N, 1 µrad under 100 N·m"),
        ),
    )
    forms = tuple(ForceLaw(bend, drive) for bend in Bend for drive in Drive)
    builds_on = "base_compliance"

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        found = [ForceLaw(Bend.STIFFENING, drive) for drive in drives(points)]
        found += [ForceLaw(Bend.LIFT_OFF, drive) for drive in drives(points, oblique=True)]
        return [(BASE, law) for law in found]

    @property
    def form_name(self) -> str:
        return str(self.variant.bend)

    def describe(self) -> tuple[Parameter, ...]:
        if self.variant.bend is Bend.STIFFENING:
            return self.described([Parameter("cubic_{motion}_at_100_{force}", 1e-6)])
        return self.driven("beyond", Parameter("lift_off_{force}", 10.0, low=-1e6, high=1e6, shape=True))

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        if self.variant.bend is Bend.STIFFENING:
            return [self.neutral()]
        free = np.zeros(2 if self.drive is Drive.OBLIQUE else 1)
        return [
            np.array([*free, load, *azimuth])
            for azimuth in self.shapes(_AROUND)
            for load in np.quantile(drive_values(self.drive, points.absolute, *azimuth), (0.25, 0.5, 0.75))
        ]

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        loads = whole_load(wrench, row)
        if self.variant.bend is Bend.STIFFENING:
            now, before = ((drive_load(self.drive, load) / 100.0) ** 3 for load in loads)
            return deflection + row.rates @ twist_of(self.drive, theta[0] * (now - before))
        amounts, hinge, azimuth = self.split(theta)
        now, before = (ca.fmax(drive_load(self.drive, load, azimuth) - hinge, 0.0) for load in loads)
        return deflection + row.rates @ twist_of(self.drive, amounts * (now - before))

    def sentence(self, values: Values) -> str:
        if self.variant.bend is Bend.STIFFENING:
            verb = "softens" if next(iter(values.values()))[0] > 0.0 else "stiffens"
            return f"The support {verb} with the load {self.where} (cubic)."
        text = "The support yields differently beyond {lift_off.best:.3g} {force}"
        return self.said(f"{text} {self.where}, as where a foot lifts off.", values)


class SupportPlay(SupportEffect):
    """Play in a body's support: the body shifts or turns by the gap where the load on the support changes sign.

    It gains gap·(g(L) − g(L_ref)) with g from −½ to ½ around the load at which the contact changes over. L is the whole
    load in one direction (`about y`, `along x`, ...), L_ref that of the reference state. The changeover has a width,
    because contacts yield and because gaps of several guides close one after another (`taken_up`). Where a pose
    coordinate varies, the gap may depend on it (` over`): the same clearance tilts a column the more the less its
    guides overlap.
    """

    identifier = "support.play"
    physics = "joint_backlash"
    declared = Declaration(
        left_out="play of a support",
        phrase="play in {component}",
        usually="clearance of feet and guides",
        port="supports",
        form="gap",
        inputs=(Input.FORCE, Input.PLACE),
        sizes=(
            Size("gap_rad*", 3e-4, STRAIN_WAVE),
            Size("gap_m*", 1e-5, "assumed: linear axis without preload"),
            Size("gap_*", 1e-4, "assumed: a guide that is worn over a part of its travel"),
        ),
    )
    forms = tuple(Posed(drive) for drive in Drive if drive is not Drive.OBLIQUE)
    quantities = (
        Parameter("gap_{motion}", 1e-5, low=0.0, high=0.1),
        Parameter("changeover_{force}", 10.0, low=-1e5, high=1e5, shape=True),
        Parameter("width_{force}", 10.0, neutral=10.0, low=1e-2, high=1e5, shape=True),
    )

    @classmethod
    def variant_from_text(cls, robot: Robot, text: str) -> Variant:
        return Posed.from_text(Drive, text)

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        ranges = [None, *over_pose(points, robot.configuration)]
        return [(BASE, Posed(drive, over)) for drive in drives(points) for over in ranges]

    @property
    def drive(self) -> Drive:
        return Drive(self.variant.form)

    @property
    def slot(self) -> tuple[Hashable, ...]:
        return self.physics, self.component, self.drive

    def describe(self) -> tuple[Parameter, ...]:
        return with_powers(super().describe(), self.variant.over)

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        load = drive_values(self.drive, points.absolute)
        spread = float(np.ptp(load))
        places = [0.0] if load.min() < 0.0 < load.max() else []
        places += [float(q) for q in np.quantile(load, (0.1, 0.3, 0.5, 0.7, 0.9))]
        free = np.zeros(len(self.parameters) - 2)
        return [np.array([*free, place, width * spread]) for place in places for width in (0.01, 0.1)]

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        now, before = (taken_up(drive_load(self.drive, load), theta[-2], theta[-1]) for load in whole_load(wrench, row))
        factors = powers(self.variant.over, row, self.robot.configuration)
        gap = sum((theta[i] * factor for i, factor in enumerate(factors)), ca.SX(0.0))
        return deflection + row.rates @ twist_of(self.drive, gap * (now - before))

    def sentence(self, values: Values) -> str:
        over = "" if self.variant.over is None else f"; this is {self.variant.over.sentence}"
        text = f"The support has play: {{gap:1e6 .3g}} µ{{motion}} {self.drive}, taken up around"
        return self.said(f"{text} {{changeover.best:.3g}} {{force}}{over}.", values)


class Line(StrEnum):
    """The direction of the line about which the body rocks."""

    X = "rocking about x"
    Y = "rocking about y"


class SupportRocking(SupportEffect):
    """Play in a body's support that lets it rock, as a machine with a short foot.

    It turns by gap·(g(M) − g(M_ref)) about a horizontal axis that is found, M being the moment of the whole load about
    that axis, M_ref that of the reference state, and g as for play about the origin of P (`taken_up`). A foot with a
    gap makes the body rock about the line of the others: the moment has the arm of the forces, and the origin of P
    moves as well as turns. Variants: `rocking about x` and `rocking about y`, the axis through a point in the plane
    normal to it.
    """

    identifier = "support.rocking"
    physics = "joint_backlash"
    declared = replace(
        SupportPlay.declared,
        usually="machines with a short foot",
        inputs=(Input.FORCE,),
        sizes=(Size("gap_rad", 3e-4, STRAIN_WAVE),),
    )
    forms = tuple(Line)
    # Under pure moments the changeover does not depend on the axis, which motion alone would have to show.
    when: ClassVar[When] = lambda robot, points: np.ptp(points.wrenches[:, :3], axis=0).any()

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        seen = measured_axes(points)
        return [(BASE, line) for line, moved in ((Line.X, {1, 2, 3}), (Line.Y, {0, 2, 4})) if len(seen & moved) > 1]

    @property
    def drive(self) -> Drive:
        return Drive.ABOUT_X if self.variant is Line.X else Drive.ABOUT_Y

    @property
    def _axis(self) -> int:
        return 0 if self.variant is Line.X else 1

    def describe(self) -> tuple[Parameter, ...]:
        across = "xy"[1 - self._axis]
        return (
            Parameter("gap_rad", 1e-5, low=0.0, high=0.1),
            Parameter(f"axis_{across}_m", 1.0, neutral=0.0, low=-FARTHEST, high=FARTHEST, shape=True),
            Parameter("axis_z_m", 1.0, neutral=0.0, low=-FARTHEST, high=FARTHEST, shape=True),
            Parameter("changeover_Nm", 10.0, low=-1e5, high=1e5, shape=True),
            Parameter("width_Nm", 10.0, neutral=10.0, low=1e-2, high=1e5, shape=True),
        )

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        position = self.robot.position(points.configurations).mean(axis=0)
        across, starts = 1 - self._axis, []
        # Below the body, and to either side: feet stand about as far apart as a body is high.
        for height in (0.0, 0.5 * position[2]):
            for shift in (0.0, -position[2], position[2]):
                line = np.array([position[0], position[1], height])
                line[across] += shift
                moment = (points.absolute[:, 3:] + np.cross(position - line, points.absolute[:, :3]))[:, self._axis]
                spread = float(np.ptp(moment))
                places = [0.0] if moment.min() < 0.0 < moment.max() else []
                places += [float(q) for q in np.quantile(moment, (0.3, 0.7))]
                starts += [np.array([0.0, line[across], height, place, 0.02 * spread]) for place in places]
        return starts

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        across = 1 - self._axis
        arm = ca.SX.zeros(3)
        arm[across], arm[2] = row.position[across] - theta[1], row.position[2] - theta[2]
        moments = ((load[3:] + ca.cross(arm, load[:3]))[self._axis] for load in whole_load(wrench, row))
        now, before = (taken_up(moment, theta[3], theta[4]) for moment in moments)
        turn = ca.SX.zeros(3)
        turn[self._axis] = theta[0] * (now - before)
        return deflection + row.rates @ ca.vertcat(ca.cross(turn, arm), turn)

    def sentence(self, values: Values) -> str:
        across = "xy"[1 - self._axis]
        line = (
            f"{'xy'[self._axis]}, around {across} = {{axis_{across}_m.best:.3g}} m, z = {{axis_z_m.best:.3g}} m in O,"
        )
        passes = "where the moment about that line passes {changeover.best:.3g} N·m."
        return self.said(f"The support has play: the body rocks by {{gap:1e6 .3g}} µrad about {line} {passes}", values)
