"""What a body stands on does under the load of the moment: it yields, is not linear, and has play."""

from collections.abc import Callable, Hashable
from dataclasses import replace
from typing import ClassVar

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import BASE, Component, symmetric
from expdesign.chain.declaration import STRAIN_WAVE, TEN_PERCENT, Declaration, Input, Size, Variant
from expdesign.chain.effect import Parameter, Values, When
from expdesign.chain.recordings.recordings import LoadedPoints, measured_axes
from expdesign.chain.row import Row
from expdesign.chain.support_effect import (
    DRIVES,
    FARTHEST,
    OBLIQUE,
    SupportEffect,
    SupportForm,
    driven,
    over_pose,
    shown_drives,
    taken_up,
    whole_load,
)
from expdesign.mechanics.robots.robot import Robot

_AXES = ("rx", "ry", "rz")


def entries(name: str, scale: float, *, diagonal: bool = False) -> tuple[Parameter, ...]:
    """Entries of a symmetric rotational compliance: its diagonal, then its upper triangle by rows unless `diagonal`."""
    pairs = [(a, a) for a in _AXES] + [(a, b) for i, a in enumerate(_AXES) for b in _AXES[i + 1 :] if not diagonal]
    return tuple(Parameter(f"{name}_{a}_{b}_rad_per_Nm", scale, low=0.0 if a == b else float("-inf")) for a, b in pairs)


def _turns(form: SupportForm, wrench: ca.SX, row: Row, state: ca.SX, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Springs about axes through the origin of P."""
    return ca.vertcat(ca.SX.zeros(3), symmetric(form.at(theta, row), 3) @ wrench[3:]), state


def _turns_about(form: SupportForm, wrench: ca.SX, row: Row, state: ca.SX, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Springs about axes through a point of O, which move P as well as turning it."""
    arm = row.position - theta[6:9]
    turn = symmetric(theta[:6], 3) @ (wrench[3:] + ca.cross(arm, wrench[:3]))
    return ca.vertcat(ca.cross(turn, arm), turn), state


_AXIAL = SupportForm(name="axes", twist=_turns, parameters=entries("compliance", 1e-6, diagonal=True))
_ROTATION = SupportForm(name="rotation", twist=_turns, parameters=entries("compliance", 1e-6))
_CENTRE = SupportForm(
    name="centre",
    twist=_turns_about,
    parameters=(
        *_ROTATION.parameters,
        *(Parameter(f"centre_{a}_m", 1.0, neutral=0.0, low=-FARTHEST, high=FARTHEST, shape=True) for a in "xyz"),
    ),
)


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
    forms = (_AXIAL, _ROTATION, _CENTRE)
    together = False

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        # Pure moments and rotations say nothing of where a body turns.
        moved = measured_axes(points) & {0, 1, 2} or np.ptp(points.wrenches[:, :3], axis=0).any()
        found = [_AXIAL, _ROTATION, *([_CENTRE] if moved else [])]
        ranges = over_pose(points, robot.configuration)
        found += [form.along(over) for over in ranges for form in (_AXIAL, _ROTATION)]
        return [(BASE, form) for form in found]

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        if self.variant != _CENTRE:
            return [self.neutral()]
        position = self.robot.position(points.configurations).mean(axis=0)
        # On the ground below the body, at its own height, and far below.
        heights = (position[2], 0.0, position[2] - 3.0)
        return [np.concatenate([np.zeros(6), [position[0], position[1], height]]) for height in heights]

    def sentence(self, values: Values) -> str:
        names = {axis[1]: f"compliance_{axis}_{axis}_rad_per_Nm" for axis in _AXES}
        known = [
            f"{{{name}:1e6 .3g}} µrad per N·m about {axis}"
            for axis, name in names.items()
            if abs(values[name][2]) < 1e299
        ]
        text = f"What the body stands on yields: {', '.join(known) or 'by an amount that is hardly known'}"
        if self.variant.over is not None:
            text += f" {self.variant.over.sentence}"
        if self.variant == _CENTRE:
            text += "; it turns about ({centre_x_m.best:.2f}, {centre_y_m.best:.2f}, {centre_z_m.best:.2f}) m in O"
        return self.said(f"{text}.", values)


def _changes(form: SupportForm, wrench: ca.SX, row: Row, of: Callable[[ca.SX], ca.SX], azimuth: ca.SX | float) -> ca.SX:
    """By how much a function of what drives differs between the whole load and that of the reference state."""
    now, before = (of(form.drive.load(load, azimuth)) for load in whole_load(wrench, row))
    return now - before


def _cubic(form: SupportForm, wrench: ca.SX, row: Row, state: ca.SX, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
    return form.drive.twist(theta[0] * _changes(form, wrench, row, lambda load: (load / 100.0) ** 3, 0.0)), state


def _beyond(form: SupportForm, wrench: ca.SX, row: Row, state: ca.SX, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
    """A hinge at a load."""
    amounts, hinge, azimuth = form.drive.split(theta)
    yields = _changes(form, wrench, row, lambda load: ca.fmax(load - hinge, 0.0), azimuth)
    return form.drive.twist(amounts * yields), state


_STIFFENING, _LIFT_OFF = "stiffening", "lift-off"
_AROUND = tuple(np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False))
_HINGE = Parameter("lift_off_{force}", 10.0, low=-1e6, high=1e6, shape=True)


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
    forms = (
        *(
            SupportForm(
                name=f"{_STIFFENING} {drive}",
                twist=_cubic,
                parameters=(Parameter("cubic_{motion}_at_100_{force}", 1e-6),),
                says="The support {first:softens|stiffens} with the load {variant.drive.where} (cubic).",
                called=_STIFFENING,
                drive=drive,
            )
            for drive in DRIVES
        ),
        *(
            SupportForm(
                name=f"{_LIFT_OFF} {drive}",
                twist=_beyond,
                parameters=drive.parameters("beyond", _HINGE),
                called=_LIFT_OFF,
                drive=drive,
            )
            for drive in (*DRIVES, OBLIQUE)
        ),
    )
    shows = driven
    builds_on = "base_compliance"
    says = (
        "The support yields differently beyond {lift_off.best:.3g} {force} {variant.drive.where}, as where a foot "
        "lifts off."
    )

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        drive = self.variant.drive
        if self.variant.called == _STIFFENING:
            return [self.neutral()]
        return drive.starts(_AROUND, lambda a: np.quantile(drive.load(points.absolute.T, *a), (0.25, 0.5, 0.75)))


_PLAY = (
    Parameter("gap_{motion}", 1e-5, low=0.0, high=0.1),
    Parameter("changeover_{force}", 10.0, low=-1e5, high=1e5, shape=True),
    Parameter("width_{force}", 10.0, neutral=10.0, low=1e-2, high=1e5, shape=True),
)


def _gap(form: SupportForm, wrench: ca.SX, row: Row, state: ca.SX, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
    moved = _changes(form, wrench, row, lambda load: taken_up(load, theta[-2], theta[-1]), 0.0)
    return form.drive.twist(form.at(theta[:-2], row) * moved), state


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
    forms = tuple(SupportForm(name=str(drive), twist=_gap, parameters=_PLAY, drive=drive) for drive in DRIVES)

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        seen = [form for form in cls.forms if form.drive in shown_drives(points)]
        ranges = over_pose(points, robot.configuration)
        return [(BASE, each) for form in seen for each in (form, *(form.along(over) for over in ranges))]

    @property
    def slot(self) -> tuple[Hashable, ...]:
        return self.physics, self.component, self.variant.drive

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        load = self.variant.drive.load(points.absolute.T)
        spread = float(np.ptp(load))
        places = [0.0] if load.min() < 0.0 < load.max() else []
        places += [float(q) for q in np.quantile(load, (0.1, 0.3, 0.5, 0.7, 0.9))]
        free = np.zeros(len(self.parameters) - 2)
        return [np.array([*free, place, width * spread]) for place in places for width in (0.01, 0.1)]

    def sentence(self, values: Values) -> str:
        over = "" if self.variant.over is None else f"; this is {self.variant.over.sentence}"
        text = "The support has play: {gap:1e6 .3g} µ{motion} {variant.drive}, taken up around"
        return self.said(f"{text} {{changeover.best:.3g}} {{force}}{over}.", values)


def _rocks(form: SupportForm, wrench: ca.SX, row: Row, state: ca.SX, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Play of the moment about a line in O along x or y, and the arm of the origin of P over it."""
    axis = form.drive.axes[0] - 3
    arm = ca.SX.zeros(3)
    arm[1 - axis], arm[2] = row.position[1 - axis] - theta[1], row.position[2] - theta[2]
    moments = ((load[3:] + ca.cross(arm, load[:3]))[axis] for load in whole_load(wrench, row))
    now, before = (taken_up(moment, theta[3], theta[4]) for moment in moments)
    turn = ca.SX.zeros(3)
    turn[axis] = theta[0] * (now - before)
    return ca.vertcat(ca.cross(turn, arm), turn), state


def _rocking(axis: int) -> SupportForm:
    about, across = "xy"[axis], "xy"[1 - axis]
    lies = (
        Parameter(f"axis_{name}_m", 1.0, neutral=0.0, low=-FARTHEST, high=FARTHEST, shape=True)
        for name in (across, "z")
    )
    return SupportForm(
        name=f"rocking about {about}",
        twist=_rocks,
        parameters=(_PLAY[0], *lies, *_PLAY[1:]),
        says=f"The support has play: the body rocks by {{gap:1e6 .3g}} µrad about {about}, around {across} = "
        f"{{axis_{across}_m.best:.3g}} m, z = {{axis_z_m.best:.3g}} m in O, where the moment about that line passes "
        "{changeover.best:.3g} N·m.",
        drive=DRIVES[3 + axis],
    )


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
    forms = (_rocking(0), _rocking(1))
    # Under pure moments the changeover does not depend on the axis, which motion alone would have to show.
    when: ClassVar[When] = lambda robot, points: np.ptp(points.wrenches[:, :3], axis=0).any()

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        seen = measured_axes(points)
        return [
            (BASE, form) for form, moved in zip(cls.forms, ({1, 2, 3}, {0, 2, 4}), strict=True) if len(seen & moved) > 1
        ]

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        position = self.robot.position(points.configurations).mean(axis=0)
        axis = self.variant.drive.axes[0] - 3
        across, starts = 1 - axis, []
        # Below the body, and to either side: feet stand about as far apart as a body is high.
        for height in (0.0, 0.5 * position[2]):
            for shift in (0.0, -position[2], position[2]):
                line = np.array([position[0], position[1], height])
                line[across] += shift
                moment = (points.absolute[:, 3:] + np.cross(position - line, points.absolute[:, :3]))[:, axis]
                spread = float(np.ptp(moment))
                places = [0.0] if moment.min() < 0.0 < moment.max() else []
                places += [float(q) for q in np.quantile(moment, (0.3, 0.7))]
                starts += [np.array([0.0, line[across], height, place, 0.02 * spread]) for place in places]
        return starts
