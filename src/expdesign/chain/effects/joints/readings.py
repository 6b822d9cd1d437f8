"""Joints that are not where they were sent: readings before they had settled, periodic errors, and warming up."""

from collections.abc import Sequence
from enum import StrEnum

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.actuator import Acting, ActuatorEffect, PeriodicError, Pitches
from expdesign.chain.component import ALL_JOINTS, Component, each_joint, each_leg
from expdesign.chain.declaration import ONLY, Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter, Values
from expdesign.chain.recordings.recordings import DEFLECTIONS, POSITIONS, LoadedPoints
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


class Cause(StrEnum):
    """Unlike creep, which shares its physics, it is no property of the arm."""

    UNSETTLED = "logged before settled"


class ReadBeforeSettled(ActuatorEffect):
    """Positions were read before the arm had settled: its joints had not yet come where they were sent.

    The joints stand at 1 − ρ of the way from where they stood in the row before (the states) to the command, so that
    the logged minus the commanded joints are a common fraction of each row's step, to first order in ρ·step:
    q = q_C − ρ·(q_C − q of the row before). A series starts settled; ρ is the same for all joints.
    """

    identifier = "joints.unsettled_position"
    physics = "creep"
    declared = Declaration(
        left_out="readings before the machine had settled",
        phrase="creep of {component}",
        usually="readings that were taken too soon",
        port="actuators",
        inputs=(Input.FORCE, Input.HISTORY),
        sizes=(Size("unsettled_*fraction", 0.02, "assumed: read when 98 % of a move have settled"),),
    )
    measurands = (POSITIONS,)
    forms = tuple(Cause)
    memory = 1
    quantities = (Parameter("unsettled_step_fraction", 1e-3, low=-0.5, high=0.95),)
    says = (
        "Positions were read before the arm had settled: {unsettled_step_fraction:100 .3g %} of every joint's step was "
        "still missing."
    )

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [ALL_JOINTS] if robot.jointed else []

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> Sequence[tuple[Component, Variant]]:
        several = len(np.unique(points.series)) < len(points)
        return super().shown(robot, points) if several else []

    def gain(self, at: Acting, row: Row, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
        missing = theta[0] * (1.0 - row.first) * (at.place - at.state)
        return -missing, at.place - missing


class LoggedBeforeSettled(ReadBeforeSettled):
    """Readings were logged before the arm had settled: part of the step from the row before is still missing.

    A row's joints have moved from where they were in the row before it (unloaded, at the start of a series) to 1 − ρ of
    the way to where the load takes them, Δq = Δq(load) − ρ·(Δq(load) − Δq(row before)). Unlike creep it does not depend
    on how long the interval is, and it ends with the row.
    """

    identifier = "joints.unsettled_reading"
    measurands = (DEFLECTIONS,)
    quantities = (Parameter("unsettled_fraction", 0.05, low=-0.5, high=0.95),)
    says = (
        "Readings were logged before the arm had settled: {unsettled_fraction:100 .1f %} of every step was still "
        "missing."
    )

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        reached = elongation - theta[0] * (elongation - state)
        return reached, reached


_TURN = 2.0 * np.pi


class JointPeriodicError(PeriodicError):
    """A joint's transmission or encoder has an error that repeats with the joint's angle.

    Once a turn for an eccentric scale, twice for an oval one, and with every tooth or wave of the gear. As for a leg,
    it is an offset in deflections of all rows of a series that depends on the joint's command. Where a robot's legs
    turn, it is theirs.
    """

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


_ORDERS = (1, 2)
"""Times a turn."""
_HARMONIC = 1.5e-4
"""rad; the largest errors that makers of strain-wave gears state are twice this."""


class JointHarmonics(Effect):
    """Errors of all joints' positions that repeat once and twice a turn: an eccentric and an oval scale or gear.

    Δq_k gains Σ_n a_nk·sin(n·q_k) + b_nk·cos(n·q_k), n = 1, 2, for every turning joint k. A calibration of an arm puts
    them there where it is asked to; `JointPeriodicError` is what a search looks for, with a period of its own.
    """

    identifier = "joints.harmonics"
    physics = "encoder_periodic_error"
    declared = Declaration(
        left_out="errors of joints that repeat with every turn",
        phrase="periodic errors of the encoders of all joints",
        usually="eccentric and oval scales and gears",
        port="actuators",
        form="harmonic",
        laws=("periodic",),
        inputs=(Input.PLACE,),
        sizes=(Size("*_rad", _HARMONIC, "assumed: as of a strain-wave gear"),),
    )
    measurands = ()

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [ALL_JOINTS] if each_joint(robot) and "rad" in robot.units else []

    @property
    def _turning(self) -> list[int]:
        return [index for index, unit in enumerate(self.robot.units) if unit == "rad"]

    def describe(self) -> tuple[Parameter, ...]:
        return tuple(
            Parameter(f"joint_{index + 1}_{name}_{order}_rad", 1e-5, low=-0.1, high=0.1, spread=_HARMONIC)
            for index in self._turning
            for order in _ORDERS
            for name in ("sine", "cosine")
        )

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        gained, place = ca.SX.zeros(elongation.shape[0]), 0
        for index in self._turning:
            for order in _ORDERS:
                angle = order * row.lengths[index]
                gained[index] += theta[place] * ca.sin(angle) + theta[place + 1] * ca.cos(angle)
                place += 2
        return elongation + gained, state

    def sentence(self, values: Values) -> str:
        largest = max(values, key=lambda name: abs(values[name][0]))
        return f"Errors of the joints repeat with every turn, the largest ({largest}) by {values[largest][0]:.3g} rad."


FEWEST = 10
"""Rows below which a slow drift is not looked for."""


class Along(StrEnum):
    """What stands for time."""

    SEQUENCE = "warm-up along sequence"


class WarmUpByRows(ActuatorEffect):
    """A joint shifts as the machine warms up, in recordings without time: along `sequence`, one row like the next.

    Δq gains drift·(e^(−n₀/ν) − e^(−n/ν)), n rows after the first of all. Deflections are relative to the first row of
    their series, which had warmed up already (n₀ is its number); positions are not, and n₀ is 0.
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
    at = each_joint
    forms = tuple(Along)
    quantities = (
        Parameter("drift_{motion}", 1e-5, low=-0.1, high=0.1),
        Parameter("constant_rows", 50.0, neutral=50.0, low=0.5, high=1e6, shape=True),
    )
    says = (
        "{subject} shifts by {drift:1e6 .3g} µ{motion} in the order of the rows, as by warming up (constant: "
        "{constant_rows.best:.3g} rows)."
    )

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> Sequence[tuple[Component, Variant]]:
        return [] if points.timed or len(points) < FEWEST else super().shown(robot, points)

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        return [np.array([0.0, constant]) for constant in np.geomspace(0.05, 1.5, 4) * len(points)]

    def gain(self, at: Acting, row: Row, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
        return theta[0] * (ca.exp(-row.reference / theta[1]) - ca.exp(-row.number / theta[1])), at.state
