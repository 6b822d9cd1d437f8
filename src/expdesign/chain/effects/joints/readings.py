"""Joints that are not where they were sent: readings before they had settled, periodic errors, and warming up."""

from dataclasses import replace
from typing import ClassVar

import casadi as ca
import numpy as np

from expdesign.chain.component import ALL_JOINTS, each_joint, each_leg, on
from expdesign.chain.declaration import Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter, Shows, Values, When
from expdesign.chain.effects.legs.transmission import EncoderPeriodicError, pitch
from expdesign.chain.form import Acting, Form
from expdesign.chain.recordings.recordings import DEFLECTIONS, POSITIONS, LoadedPoints
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


def _short_of_command(at: Acting, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Of the step of the command; a series starts settled."""
    missing = theta[0] * (1.0 - at.row.first) * (at.place - at.state)
    return -missing, at.place - missing


def _short_of_load(at: Acting, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Of the step of what the load does; a series starts unloaded."""
    missing = theta[0] * (at.elongation - at.state)
    return -missing, at.elongation - missing


class ReadBeforeSettled(Effect):
    """Positions were read before the arm had settled: its joints had not yet come where they were sent.

    The joints stand at 1 − ρ of the way from where they stood in the row before to the command, so that the logged
    minus the commanded joints are a common fraction of each row's step, to first order in ρ·step. ρ is the same for all
    joints.
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
    forms: ClassVar[tuple[Variant, ...]] = (Form(_short_of_command, "logged before settled", memory=1),)
    at = on(lambda robot: robot.jointed, ALL_JOINTS)
    when: ClassVar[When] = lambda robot, points: len(np.unique(points.series)) < len(points)
    quantities = (Parameter("unsettled_step_fraction", 1e-3, low=-0.5, high=0.95),)
    says = (
        "Positions were read before the arm had settled: {unsettled_step_fraction:100 .3g %} of every joint's step was "
        "still missing."
    )


class LoggedBeforeSettled(ReadBeforeSettled):
    """Readings were logged before the arm had settled: part of the step from the row before is still missing.

    A row's joints have moved from where they were in the row before it (unloaded, at the start of a series) to 1 − ρ of
    the way to where the load takes them, Δq = Δq(load) − ρ·(Δq(load) − Δq(row before)). Unlike creep it does not depend
    on how long the interval is, and it ends with the row.
    """

    identifier = "joints.unsettled_reading"
    measurands = (DEFLECTIONS,)
    forms = (Form(_short_of_load, "logged before settled", memory=1),)
    quantities = (Parameter("unsettled_fraction", 0.05, low=-0.5, high=0.95),)
    says = (
        "Readings were logged before the arm had settled: {unsettled_fraction:100 .1f %} of every step was still "
        "missing."
    )


_TURN = 2.0 * np.pi


def _four_commands(robot: Robot, points: LoadedPoints) -> Shows:
    """A joint shows what repeats with its angle where it was sent to four places or more."""
    coordinates = robot.actuator_coordinates(points.configurations)
    return lambda joint, form: len(np.unique(coordinates[:, joint.index])) >= 4


class JointPeriodicError(EncoderPeriodicError):
    """A joint's transmission or encoder has an error that repeats with the joint's angle.

    Once a turn for an eccentric scale, twice for an oval one, and with every tooth or wave of the gear. As for a leg,
    it is an offset in deflections of all rows of a series that depends on the joint's command. Where a robot's legs
    turn, it is theirs.
    """

    identifier = "joints.periodic_error"
    at = on(lambda robot: robot.jointed or set(robot.units) == {"rad"}, each_joint, each_leg)
    when: ClassVar[When] = Effect.when
    shows = _four_commands
    amplitude = (1e-5, 0.1)
    pitches = {  # noqa: RUF012
        "m": (pitch(1e-4, 1e-3, 2.5e-4, 1e3), 5e-4),
        "rad": (pitch(0.1, np.pi, _TURN / 120.0, 2.0 * _TURN), _TURN / 60.0),
    }
    most_starts = 120
    noun = "position"


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
    declared = replace(
        EncoderPeriodicError.declared,
        left_out="errors of joints that repeat with every turn",
        phrase="periodic errors of the encoders of all joints",
        usually="eccentric and oval scales and gears",
        sizes=(Size("*_rad", _HARMONIC, "assumed: as of a strain-wave gear"),),
    )
    measurands = ()

    at = on(lambda robot: robot.jointed and "rad" in robot.units, ALL_JOINTS)

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
