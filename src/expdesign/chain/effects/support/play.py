"""Play in a body's support: it shifts or turns by a gap about its own origin, or rocks about a line that is found."""

from collections.abc import Hashable
from enum import StrEnum
from typing import ClassVar

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import BASE, Component
from expdesign.chain.declaration import STRAIN_WAVE, Declaration, Input, Size, Variant
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
    declared = Declaration(
        left_out="play of a support",
        phrase="play in {component}",
        usually="machines with a short foot",
        port="supports",
        form="gap",
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
        across = 1 - self._axis
        starts = []
        for height in (0.0, 0.5 * position[2]):
            arm = position - np.array([position[0], position[1], height])
            moment = (points.absolute[:, 3:] + np.cross(arm, points.absolute[:, :3]))[:, self._axis]
            spread = float(np.ptp(moment))
            places = [0.0] if moment.min() < 0.0 < moment.max() else []
            places += [float(q) for q in np.quantile(moment, (0.3, 0.7))]
            starts += [np.array([0.0, position[across], height, place, 0.02 * spread]) for place in places]
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
