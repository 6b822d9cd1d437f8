"""Errors of the load: of its centre of mass, its direction, its mass or scale, its sensor, and a tool nobody stated."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import ClassVar

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import PAYLOAD, PLATFORM, Component, heavy_links, on, on_any, tilted_load
from expdesign.chain.declaration import Declaration, Input, Size, Variant, rounded
from expdesign.chain.effect import Effect, Parameter, Values, When
from expdesign.chain.form import ONLY, Form
from expdesign.chain.recordings.recordings import POSITIONS, LoadedPoints
from expdesign.chain.row import Row
from expdesign.mechanics.robots.orientation import moment
from expdesign.mechanics.robots.robot import Robot


class PayloadComOffset(Effect):
    """The payload's centre of mass is not where it was assumed (theory.md 5.2: L = [0; −[m g]ₓ R]).

    The force acts at R·(c + d): its moment about the origin of P grows by (R·d) × f.
    """

    identifier = "load.com_offset"
    physics = "payload_com_offset"
    declared = Declaration(
        left_out="error of the payload's centre of mass",
        phrase="a centre of mass that is not where it was assumed",
        usually="liquids, loose parts and drawings",
        port="centre of mass",
        laws=("load",),
        inputs=(Input.FORCE,),
        sizes=(Size("com_d?_m", 1e-3, "assumed: centre of mass from a drawing, 1 mm"),),
    )

    at = on(lambda robot: robot.coordinates.centre_of_mass, PAYLOAD)
    # A body's wrench is about a known point; without payload columns there is no centre of mass that was assumed.
    when: ClassVar[When] = lambda robot, points: not robot.on_support or points.payload is not None
    quantities = (Parameter("com_d{axis}_m", 1e-3, low=-0.5, high=0.5),)
    says = (
        "The payload's centre of mass lies ({all:1e3 .2f}) mm from where it was assumed (platform axes); the direction "
        "along gravity is the least certain."
    )

    def load(self, wrench: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        split = self.robot.coordinates.translations
        return wrench + ca.vertcat(ca.SX.zeros(split), moment(row.rotation @ theta, wrench[:split]))


class LoadDirectionTilt(Effect):
    """Gravity, or the load, does not act along the assumed direction (theory.md 5.2, tilt of gravity).

    The force is turned by small angles about x and y of O (`tilted_load`).
    """

    identifier = "load.direction_tilt"
    physics = "load_direction_tilt"
    declared = Declaration(
        left_out="gravity or load in another direction",
        phrase="a load that is not along its assumed direction",
        usually="machines that were not levelled, slanting cables",
        port="load direction",
        laws=("load",),
        inputs=(Input.FORCE,),
        sizes=(Size("tilt_?_rad", 5e-4, "assumed: a machinist's level, 0.5 mm/m"),),
    )

    at = on_any(PAYLOAD)

    def describe(self) -> tuple[Parameter, ...]:
        names = ("tilt_x_rad", "tilt_y_rad") if self.robot.coordinates.translations > 2 else ("tilt_z_rad",)
        return tuple(Parameter(name, 1e-3, low=-0.5, high=0.5) for name in names)

    def load(self, wrench: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        return tilted_load(wrench, row, theta)

    def sentence(self, values: Values) -> str:
        parts = " and ".join(f"{{{name}:1e3 .2f}} mrad ({name[:6]})" for name in values)
        return self.said(f"The load acts {parts} away from the assumed direction.", values)


_RELATIVE_WIDTH = 0.02
"""Loads within this fraction of each other count as the same weight."""
_MOST_WEIGHTS = 12
_SMALLEST = 1e-9
"""N; less is no load."""


_NEWTON, _AND_MORE = " newton", " newton and more"
"""How a variant's text ends that names one load, and those from a size on."""


def _constant(wrench: ca.SX, row: Row, theta: ca.SX, *, least: float = 0.0) -> ca.SX:
    """A constant is added to every load from a size (N) on."""
    force = ca.norm_2(row.wrench[: row.gravity.shape[0]])
    concerned = force > max(least * (1.0 - 1e-5), _SMALLEST)
    return wrench * (1.0 + ca.if_else(concerned, theta[0] / ca.fmax(force, _SMALLEST), 0.0))


def _share(wrench: ca.SX, row: Row, theta: ca.SX, *, size: float) -> ca.SX:
    """The load of a size (N) is wrong by a fraction."""
    force = ca.norm_2(row.wrench[: row.gravity.shape[0]])
    concerned = ca.logic_and(force > size * (1.0 - 1e-5), force < size * (1.0 + _RELATIVE_WIDTH))
    return wrench * (1.0 + ca.if_else(concerned, theta[0], 0.0))


_FORGOTTEN = Form(
    name="forgotten",
    load=_constant,
    parameters=(Parameter("forgotten_N", 1.0, low=-1e5, high=1e5),),
    says="Every load is {first:+.3g} N off, as by a forgotten part.",
)


_EVERY = Form(
    name="every",
    load=lambda wrench, row, theta: wrench * (1.0 + theta[0]),
    parameters=(Parameter("relative_mass_error", 0.01, low=-0.9, high=9.0),),
    says="Every load differs from what is stated by {first:100 +.2f %}.",
)


def _weight(size: float) -> Form:
    """One weight (N) is wrong."""
    return Form(
        name=f"{size:.6g}{_NEWTON}",
        load=partial(_share, size=rounded(size)),
        parameters=(Parameter("relative_mass_error", 0.01, low=-0.9, high=9.0),),
        says=f"The load of {size:.4g} N ({size / 9.80665:.4g} kg of weight) is really {{first:100 +.2f %}} of that "
        "heavier.",
    )


def _disc(size: float) -> Form:
    """The disc that makes a stack as heavy as this (N) is wrong."""
    return Form(
        name=f"{size:.6g}{_AND_MORE}",
        load=partial(_constant, least=rounded(size)),
        parameters=(Parameter("disc_error_N", 1.0, low=-1e5, high=1e5),),
        says=f"Every load of {size:.4g} N and more is {{first:+.3g}} N off, as by one disc of a stack.",
    )


class PayloadMassError(Effect):
    """The payload's mass, or the scale of the wrench, is not as assumed.

    An error that is the same fraction of every load is a change of scale of all compliances, which no deflection can
    tell from soft legs (theory.md 5.2); positions of an arm can, whose own weight is another load. What deflections
    show is one weight that is wrong among others, a mass that was forgotten (an adapter plate) in all of them, and one
    disc of a stack that is wrong in every load that contains it.

    Variants: `N newton`: the load of that size is wrong by a fraction; `forgotten`: a constant is added to all;
    `N newton and more`: a constant is added to these, as the discs of a stack are put on one by one; `every`: all are
    wrong by one fraction.
    """

    identifier = "load.mass_error"
    physics = "payload_mass_error"
    declared = Declaration(
        left_out="error of a mass or of the scale of a wrench",
        phrase="masses that are not what was assumed",
        usually="weights that were not weighed",
        port="payload",
        laws=("load",),
        inputs=(Input.FORCE,),
        sizes=(
            Size(
                "relative_mass_error",
                5e-3,
                "assumed: weights from a gymnasium; class M3 of OIML R 111-1:2004 would be 5e-4",
            ),
            Size("forgotten_N", 1.0, "assumed: a shackle or a plate of 0.1 kg"),
            Size("disc_error_N", 1.0, "assumed: as for what was forgotten"),
        ),
    )

    at = on_any(PAYLOAD)
    # Changes of a load are no weights, and what acts on a body without payload columns is what a force plate read.
    when: ClassVar[When] = lambda robot, points: (
        np.array_equal(points.absolute, points.wrenches) and (points.payload is not None or not robot.on_support)
    )
    forms = (_FORGOTTEN, _EVERY)  # the loads of recordings decide about the others

    @classmethod
    def variant_from_text(cls, robot: Robot, text: str) -> Variant:
        for ending, form in ((_NEWTON, _weight), (_AND_MORE, _disc)):
            if text.endswith(ending):
                return form(float(text.removesuffix(ending)))
        return super().variant_from_text(robot, text)

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        sizes = _sizes(np.linalg.norm(points.wrenches[:, : robot.coordinates.translations], axis=1))
        own_weight = points.measurand is POSITIONS and heavy_links(robot)
        found = [_EVERY] if sizes and own_weight else []
        found += [_FORGOTTEN] if len(sizes) > 1 else []
        if 1 < len(sizes) <= _MOST_WEIGHTS:
            # From the smallest on it is what was forgotten, and the largest alone is one weight.
            found += [*map(_weight, sizes), *map(_disc, sizes[1:-1])]
        return [(PAYLOAD, form) for form in found]


def _sizes(forces: FloatArray) -> list[float]:
    """The least of each group of loads of one size, rising."""
    sizes: list[float] = []
    for value in np.sort(forces[forces > _SMALLEST]):
        if not sizes or value > sizes[-1] * (1.0 + _RELATIVE_WIDTH):
            sizes.append(float(value))
    return sizes


_REFERENCE = 100.0
"""N or N·m; the load to which an error of the sensor that grows refers."""


_GROWING = "growing"


def _scaled(wrench: ca.SX, row: Row, theta: ca.SX, *, index: int, growing: bool = False) -> ca.SX:
    """The load on one axis is wrong by a share, or by one that grows in proportion to the whole of it."""
    gained = ca.SX.zeros(wrench.shape[0])
    if not growing:
        gained[index] = theta[0] * wrench[index]
        return wrench + gained
    before = row.absolute[index] - row.wrench[index]
    now = before + wrench[index]
    gained[index] = theta[0] * (now * ca.fabs(now) - before * ca.fabs(before)) / _REFERENCE
    return wrench + gained


def _sensed(index: int, column: str) -> tuple[Form, Form]:
    """Errors on the axis of a column of the wrench (`fx_N`)."""
    axis, unit = column.rsplit("_", 1)
    same = Form(
        name=axis,
        load=partial(_scaled, index=index),
        parameters=(Parameter("relative_mass_error", 0.01, low=-0.99, high=9.0),),
        says=f"The load along {axis} is really {{first:100 +.2f %}} larger than stated on every row.",
    )
    grows = Form(
        name=f"{axis} {_GROWING}",
        load=partial(_scaled, index=index, growing=True),
        parameters=(Parameter(f"relative_error_at_100{unit}", 0.01, low=-0.9, high=9.0),),
        says=f"The load along {axis} is really larger than stated, the more the larger it is: {{first:100 +.2f %}} at "
        f"100 {unit.replace('Nm', 'N·m')}.",
        called=_GROWING,
    )
    return same, grows


class ForceSensor(Effect):
    """The sensor by which loads are known does not read in proportion on one axis, or has a wrong scale there.

    A scale that is wrong on all axes alike is a change of all compliances (theory.md 5.2) and cannot be seen; on one
    axis it can, and so can a scale that grows with the load. The load on one axis is (1 + s)·w (variant `fx`), or
    w + s·w·|w|/100 (`fx growing`), of the whole load.
    """

    identifier = "load.force_sensor"
    physics = "payload_mass_error"
    declared = replace(
        PayloadMassError.declared,
        phrase="a force sensor that does not read in proportion",
        usually="force sensors and load cells",
        form="constant",
        laws=(),
        sizes=(
            Size("relative_mass_error", 5e-3, "assumed: a load cell of class 0.5 (ISO 376:2011)"),
            Size("relative_error_at_100*", 5e-3, "assumed: the same at the targets' loads", "own deflection"),
        ),
    )

    at = on_any(PAYLOAD)
    # Payloads are weighed (`PayloadMassError`); a body's base model does not deflect.
    when: ClassVar[When] = lambda robot, points: not robot.on_support and points.payload is None

    @classmethod
    def variants(cls, robot: Robot) -> list[Variant]:
        return [form for index, column in enumerate(robot.coordinates.wrench) for form in _sensed(index, column)]

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> Sequence[tuple[Component, Variant]]:
        varies = np.ptp(points.absolute, axis=0) > 1e-9 * np.abs(points.absolute).max(initial=0.0)
        return [(PAYLOAD, form) for form, seen in zip(cls.variants(robot), np.repeat(varies, 2), strict=True) if seen]


_LIGHTEST = 1e-9
"""kg; a centre of less is not told."""


class UnknownTool(Effect):
    """A tool or a payload of unknown mass and centre rides on the tip in every row.

    Its weight is m·g, at R·c about the origin of P; the first moments m·c (`tool_moment_x_kgm`) are fitted, in which
    it is linear, and the centre of mass is reported. In deflections it is there before and after, and cancels. Of a
    robot with several tips each may have a tool (variants: their names), which loads the joints that carry it in rows
    of every tip, and the base's own compliance in rows of its own tip alone.
    """

    identifier = "load.tool"
    physics = "payload_mass_error"
    declared = replace(
        PayloadMassError.declared,
        left_out="a tool that nothing states",
        usually="cables and adapters",
        laws=(),
        inputs=(Input.PLACE,),
        sizes=(
            Size("tool_mass_kg", 0.1, "assumed: a cable or an adapter of 0.1 kg that no drawing has"),
            Size("tool_moment_?_kgm", 0.01, "assumed: the same at 0.1 m"),
        ),
    )
    measurands = (POSITIONS,)

    @classmethod
    def variants(cls, robot: Robot) -> Sequence[Variant]:
        tips = robot.links.tree.tips if robot.jointed else ()
        return [Form(name=name) for name in tips] if len(tips) > 1 else [ONLY]

    at = on(lambda robot: robot.coordinates.centre_of_mass, PLATFORM)
    together = True
    quantities = (
        Parameter("tool_mass_kg", 1.0, low=0.0, high=1e6),
        Parameter("tool_moment_{axis}_kgm", 0.1),
    )

    def load(self, wrench: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        weight = ca.vertcat(theta[0] * row.gravity, moment(row.rotation @ theta[1:], row.gravity))
        return wrench + (weight if self.variant == ONLY else self._own_row(row) * weight)

    def _own_row(self, row: Row) -> ca.SX:
        """1 in rows of the tip that has the tool, of several, and 0 in others."""
        tree = self.robot.links.tree
        return tree.looked_at(row.pose)[tree.tips.index(self.variant.name)]

    def own_weight_change(self, row: Row, theta: ca.SX) -> ca.SX:
        """In rows of other tips the tool weighs as a part of the robot."""
        if self.variant == ONLY:
            return super().own_weight_change(row, theta)
        tree = self.robot.links.tree
        q = ca.SX.sym("q", len(self.robot.configuration))
        pose = tree.forward(q)[self.variant.name]
        # The first moments are no functions of q: their sum with the mass is m·p, of which gravity makes the torque.
        potential = ca.dot(row.gravity, theta[0] * pose[:3, 3] + pose[:3, :3] @ theta[1:])
        torque = ca.gradient(potential, q)[: len(self.robot.stiffness)]
        return (1.0 - self._own_row(row)) * ca.substitute(torque, q, row.pose)

    def reported(self, theta: ca.SX) -> dict[str, ca.SX]:
        mass = ca.if_else(ca.fabs(theta[0]) > _LIGHTEST, theta[0], _LIGHTEST)
        centre = {f"tool_com_{axis}_m": theta[1 + i] / mass for i, axis in enumerate(self.robot.coordinates.axes)}
        return {"tool_mass_kg": theta[0], **centre}

    def sentence(self, values: Values) -> str:
        centre = ", ".join(f"{1e3 * values[name][0]:.0f}" for name in values if name.startswith("tool_com"))
        tip = "the tip" if self.variant == ONLY else "the tip `{variant}`"
        rides = f"rides on {tip}, its centre of mass at ({centre}) mm in its axes."
        return self.said(f"A tool of {{tool_mass_kg:.3g}} kg that nothing accounts for {rides}", values)
