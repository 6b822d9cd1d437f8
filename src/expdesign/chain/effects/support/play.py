"""Play in a body's support: the body shifts or rocks by the gap where the load on the support changes sign."""

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.chain.support import (
    OBLIQUE,
    drive_load,
    drive_values,
    drives,
    over_pose,
    powers,
    twist_of,
    unit_of,
    whole_load,
    with_powers,
)
from expdesign.recordings.recordings import LoadedPoints
from expdesign.robots.body import Body
from expdesign.robots.robot import Robot


class SupportPlay(Effect):
    """The body gains gap·(g(L) − g(L_ref)) with g from −½ to ½ around the load at which the contact changes over.

    L is the whole load in one direction (`about y`, `along x`, ...), L_ref that of the reference state. The changeover
    has a width, because contacts yield and because gaps of several guides close one after another: g = ½·x/√(1 + x²),
    x = (L − changeover)/width. Where a pose coordinate varies, the gap may depend on it (` over`): the same clearance
    tilts a column the more the less its guides overlap.
    """

    physics = "joint_backlash"

    @classmethod
    def places(cls, robot: Robot, points: LoadedPoints) -> list[tuple[str, str]]:
        if not isinstance(robot, Body):
            return []
        endings = ["", *over_pose(points, robot.configuration)]
        return [("base", f"{drive}{ending}") for drive in drives(points) for ending in endings]

    @property
    def drive(self) -> str:
        """Direction of the load."""
        return self.variant.split(" over ")[0]

    @property
    def slot(self) -> tuple[str, str]:
        return self.physics, f"{self.component} {self.drive}"

    def describe(self) -> tuple[Parameter, ...]:
        force, motion = unit_of(self.drive)
        scale = 10.0
        return with_powers(
            (
                Parameter(f"gap_{motion}", 1e-5, low=0.0, high=0.1),
                Parameter(f"changeover_{force}", scale, low=-1e5, high=1e5, shape=True),
                Parameter(f"width_{force}", scale, neutral=10.0, low=1e-2, high=1e5, shape=True),
            ),
            self.variant,
        )

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        assert self.drive != OBLIQUE
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

        factors = powers(self.variant, row, self.robot.configuration)
        gap = sum((theta[i] * factor for i, factor in enumerate(factors)), ca.SX(0.0))
        return deflection + row.rates @ twist_of(self.drive, gap * (place(now) - place(before)))

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        force, motion = unit_of(self.drive)
        gap, at = values[f"gap_{motion}"], values[f"changeover_{force}"]
        text = (
            f"The support has play: {1e6 * gap[0]:.3g} ({1e6 * gap[1]:.3g} to {1e6 * gap[2]:.3g}) µ{motion} "
            f"{self.drive}, taken up around {at[0]:.3g} {'N·m' if force == 'Nm' else 'N'}"
        )
        if " over " in self.variant:
            name, low, _, high = self.variant.split(" over ")[1].split()
            text += f"; this is halfway between {name} = {low} and {high}, and it changes with {name}"
        return text + "."
