"""A joint shifts as the machine warms up, in recordings without time: along `sequence`, one row being like the next.

Deflections are relative to the first row of their series, which had warmed up already; positions are not.
"""

from collections.abc import Sequence
from enum import StrEnum

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import Component, each_joint, turning
from expdesign.chain.declaration import Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot

FEWEST = 10
"""Rows below which a slow drift is not looked for."""


class Along(StrEnum):
    """What stands for time."""

    SEQUENCE = "warm-up along sequence"


class WarmUpByRows(Effect):
    """Δq gains drift·(e^(−n₀/ν) − e^(−n/ν)), n rows after the first of all; in deflections n₀ is the number of the
    first row of the series, in positions 0.
    """

    physics = "thermal_drift"
    declared = Declaration(
        left_out="motion with temperature or time, whatever the load",
        phrase="thermal drift of {component}",
        usually="motors and gears that warm up",
        port="actuators",
        inputs=(Input.TIME,),
        sizes=(
            Size("drift_m", 5e-5, "assumed: warming up by 10 K"),
            Size("drift_rad", 1e-4, "assumed: warming up by 10 K"),
        ),
    )
    forms = tuple(Along)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return each_joint(robot)

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> Sequence[tuple[Component, Variant]]:
        timed = points.time is not None and bool(np.any(np.diff(points.time) > 0.0))
        return [] if timed or len(points) < FEWEST else super().shown(robot, points)

    def describe(self) -> tuple[Parameter, ...]:
        motion = "rad" if turning(self.robot, self.actuators) else "m"
        constant = Parameter("constant_rows", 50.0, neutral=50.0, low=0.5, high=1e6, shape=True)
        return (Parameter(f"drift_{motion}", 1e-5, low=-0.1, high=0.1), constant)

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        return [np.array([0.0, constant]) for constant in np.geomspace(0.05, 1.5, 4) * len(points)]

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        gained = ca.SX.zeros(elongation.shape[0])
        gained[self.component.index] = theta[0] * (ca.exp(-row.reference / theta[1]) - ca.exp(-row.number / theta[1]))
        return elongation + gained, state

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        name, value = next(iter(values.items()))
        unit = "µrad" if name == "drift_rad" else "µm"
        size = f"{1e6 * value[0]:.3g} ({1e6 * value[1]:.3g} to {1e6 * value[2]:.3g}) {unit}"
        rows = f"{values['constant_rows'][0]:.3g} rows"
        return f"{self.subject} shifts by {size} in the order of the rows, as by warming up (constant: {rows})."
