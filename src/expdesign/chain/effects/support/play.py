"""Play in a body's support: the body shifts or rocks by the gap where the load on the support changes sign."""

from collections.abc import Hashable
from dataclasses import dataclass

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import BASE, Component
from expdesign.chain.declaration import STRAIN_WAVE, Declaration, Input, Size, Variant
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
    over_pose,
    powers,
    split_over,
    twist_of,
    unit_of,
    whole_load,
    with_powers,
)
from expdesign.mechanics.robots.robot import Robot


@dataclass(frozen=True)
class PlayDrive:
    """The load that takes up the play, and the range of a pose coordinate over which the gap is a parabola."""

    drive: Drive
    over: Over | None = None

    def __str__(self) -> str:
        return f"{self.drive}{ending(self.over)}"


class SupportPlay(Effect):
    """The body gains gap·(g(L) − g(L_ref)) with g from −½ to ½ around the load at which the contact changes over.

    L is the whole load in one direction (`about y`, `along x`, ...), L_ref that of the reference state. The changeover
    has a width, because contacts yield and because gaps of several guides close one after another: g = ½·x/√(1 + x²),
    x = (L − changeover)/width. Where a pose coordinate varies, the gap may depend on it (` over`): the same clearance
    tilts a column the more the less its guides overlap.
    """

    physics = "joint_backlash"
    declared = Declaration(
        left_out="play of a support",
        phrase="play in {component}",
        usually="clearance of feet and guides",
        port="supports",
        inputs=(Input.FORCE, Input.PLACE),
        sizes=(
            Size("gap_rad*", 3e-4, STRAIN_WAVE),
            Size("gap_m*", 1e-5, "assumed: linear axis without preload"),
            Size("gap_*", 1e-4, "assumed: a guide that is worn over a part of its travel"),
        ),
    )

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [BASE] if robot.on_support else []

    @classmethod
    def variant_from_text(cls, robot: Robot, text: str) -> Variant:
        drive, over = split_over(text)
        return PlayDrive(Drive(drive), over)

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        if not robot.on_support:
            return []
        ranges = [None, *over_pose(points, robot.configuration)]
        return [(BASE, PlayDrive(drive, over)) for drive in drives(points) for over in ranges]

    @property
    def drive(self) -> Drive:
        """Direction of the load."""
        drive: Drive = self.variant.drive
        return drive

    @property
    def slot(self) -> tuple[Hashable, ...]:
        return self.physics, self.component, self.drive

    def describe(self) -> tuple[Parameter, ...]:
        force, motion = unit_of(self.drive)
        scale = 10.0
        return with_powers(
            (
                Parameter(f"gap_{motion}", 1e-5, low=0.0, high=0.1),
                Parameter(f"changeover_{force}", scale, low=-1e5, high=1e5, shape=True),
                Parameter(f"width_{force}", scale, neutral=10.0, low=1e-2, high=1e5, shape=True),
            ),
            self.variant.over,
        )

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        assert self.drive is not Drive.OBLIQUE
        load = drive_values(self.drive, points.absolute)
        spread = float(np.ptp(load))
        places = [0.0] if load.min() < 0.0 < load.max() else []
        places += [float(q) for q in np.quantile(load, (0.1, 0.3, 0.5, 0.7, 0.9))]
        free = np.zeros(len(self.parameters) - 2)
        return [np.array([*free, place, width * spread]) for place in places for width in (0.01, 0.1)]

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        now, before = (drive_load(self.drive, load) for load in whole_load(wrench, row))
        changeover, width = theta[-2], theta[-1]

        def place(load: ca.SX) -> ca.SX:
            x = (load - changeover) / width
            return 0.5 * x / ca.sqrt(1.0 + x**2)

        factors = powers(self.variant.over, row, self.robot.configuration)
        gap = sum((theta[i] * factor for i, factor in enumerate(factors)), ca.SX(0.0))
        return deflection + row.rates @ twist_of(self.drive, gap * (place(now) - place(before)))

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        force, motion = unit_of(self.drive)
        gap, at = values[f"gap_{motion}"], values[f"changeover_{force}"]
        text = (
            f"The support has play: {1e6 * gap[0]:.3g} ({1e6 * gap[1]:.3g} to {1e6 * gap[2]:.3g}) µ{motion} "
            f"{self.drive}, taken up around {at[0]:.3g} {'N·m' if force == 'Nm' else 'N'}"
        )
        if self.variant.over is not None:
            text += f"; this is {self.variant.over.sentence}"
        return text + "."
