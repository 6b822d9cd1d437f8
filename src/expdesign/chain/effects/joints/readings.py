"""Positions were read before the arm had settled: its joints had not yet come where they were sent.

The joints stand at 1 − ρ of the way from where they stood in the row before to the command, so that the logged minus
the commanded joints are a common fraction of each row's step. To first order in ρ·step; a series starts settled.

Readings were logged before the arm had settled: part of the step from the row before is still missing.

A row's joints have moved from where they were in the row before it (unloaded, at the start of a series) to 1 − ρ of the
way to where the load takes them. Unlike creep it does not depend on how long the interval is, and it ends with the row.

A joint's transmission or encoder has an error that repeats with the joint's angle.

Once a turn for an eccentric scale, twice for an oval one, and with every tooth or wave of the gear. As for a leg,
it is an offset in deflections of all rows of a series that depends on the joint's command.

A joint shifts as the machine warms up, in recordings without time: along `sequence`, one row being like the next.

Deflections are relative to the first row of their series, which had warmed up already; positions are not.
"""

from collections.abc import Sequence
from enum import StrEnum

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import ALL_JOINTS, Component, each_joint, each_leg, turning
from expdesign.chain.declaration import ONLY, Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.periodic_error import PeriodicError, Pitches
from expdesign.chain.recordings.recordings import DEFLECTIONS, POSITIONS, LoadedPoints
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


class Cause(StrEnum):
    """Unlike creep, which shares its physics, it is no property of the arm."""

    UNSETTLED = "logged before settled"


class Unsettled(Effect):
    """A common fraction of every joint's step from the row before is still missing; the states are the joints'."""

    physics = "creep"
    declared = Declaration(
        left_out="readings before the machine had settled",
        phrase="creep of {component}",
        usually="readings that were taken too soon",
        port="actuators",
        inputs=(Input.FORCE, Input.HISTORY),
        sizes=(Size("unsettled_*fraction", 0.02, "assumed: read when 98 % of a move have settled"),),
    )
    forms = tuple(Cause)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [ALL_JOINTS] if robot.jointed else []

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> Sequence[tuple[Component, Variant]]:
        several = len(np.unique(points.series)) < len(points)
        return super().shown(robot, points) if several else []


class ReadBeforeSettled(Unsettled):
    """q = q_C − ρ·(q_C − q of the row before); ρ is `unsettled_step_fraction`, the same for all joints."""

    identifier = "joints.unsettled_position"

    measurands = (POSITIONS,)

    def describe(self) -> tuple[Parameter, ...]:
        self.states = len(self.robot.stiffness)
        return (Parameter("unsettled_step_fraction", 1e-3, low=-0.5, high=0.95),)

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        step = (1.0 - row.first) * (row.lengths - state)
        missing = theta[0] * step
        return elongation - missing, row.lengths - missing

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        v = values["unsettled_step_fraction"]
        size = f"{100 * v[0]:.3g} % ({100 * v[1]:.3g} to {100 * v[2]:.3g} %)"
        return f"Positions were read before the arm had settled: {size} of every joint's step was still missing."


class LoggedBeforeSettled(Unsettled):
    """Δq = Δq(load) − ρ·(Δq(load) − Δq(row before)); ρ is `unsettled_fraction`, the same for all joints."""

    identifier = "joints.unsettled_reading"

    measurands = (DEFLECTIONS,)

    def describe(self) -> tuple[Parameter, ...]:
        self.states = len(self.robot.stiffness)
        return (Parameter("unsettled_fraction", 0.05, low=-0.5, high=0.95),)

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        reached = elongation - theta[0] * (elongation - state)
        return reached, reached

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        v = values["unsettled_fraction"]
        size = f"{100 * v[0]:.1f} % ({100 * v[1]:.1f} to {100 * v[2]:.1f} %)"
        return f"Readings were logged before the arm had settled: {size} of every step was still missing."


_TURN = 2.0 * np.pi


class JointPeriodicError(PeriodicError):
    """Of the gear or scale of a joint; where a robot's legs turn, of theirs."""

    identifier = "joints.periodic_error"
    amplitude = (1e-5, 0.1)
    pitches = {  # noqa: RUF012
        "m": Pitches(1e-4, 1e-3, 2.5e-4, 1e3, finest=5e-4),
        "rad": Pitches(0.1, np.pi, _TURN / 120.0, 2.0 * _TURN, finest=_TURN / 60.0),
    }
    most_starts = 120
    noun = "position"

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        rotary = set(robot.units) == {"rad"}
        return each_joint(robot) or (each_leg(robot) if rotary else [])

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> list[tuple[Component, Variant]]:
        coordinates = robot.actuator_coordinates(points.configurations)
        commands = [len(np.unique(coordinates[:, i])) for i in range(len(robot.stiffness))]
        return [(joint, ONLY) for joint, count in zip(cls.components(robot), commands, strict=False) if count >= 4]


FEWEST = 10
"""Rows below which a slow drift is not looked for."""


class Along(StrEnum):
    """What stands for time."""

    SEQUENCE = "warm-up along sequence"


class WarmUpByRows(Effect):
    """Δq gains drift·(e^(−n₀/ν) − e^(−n/ν)), n rows after the first of all; in deflections n₀ is the number of the
    first row of the series, in positions 0.
    """

    identifier = "joints.warm_up_by_rows"
    physics = "thermal_drift"
    declared = Declaration(
        left_out="motion with temperature or time, whatever the load",
        phrase="thermal drift of {component}",
        usually="motors and gears that warm up",
        port="actuators",
        form="exponential",
        laws=("offset",),
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
