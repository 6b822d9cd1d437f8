"""Frames turned by quarter turns, or left-handed: of the instrument, of the load, of gravity, and of the angles."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from itertools import permutations, product

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.assurance.plausibility.evidence import Evidence, Hypothesis
from expdesign.assurance.plausibility.mistakes.mistake import Alternative, Mistake
from expdesign.mechanics.robots.orientation import Orientation, angles_of, rotation_matrix
from expdesign.mechanics.symbolic import BatchFunction


@cache
def axis_turns(dimension: int) -> tuple[FloatArray, ...]:
    """All rotations and reflections that take axes to axes, but the identity, rotations first: 47 in space, 7 in the
    plane. Columns are the axes of the turned frame.
    """
    found = []
    for order in permutations(range(dimension)):
        for signs in product((1.0, -1.0), repeat=dimension):
            turn = np.zeros((dimension, dimension))
            turn[list(order), range(dimension)] = signs
            found.append(turn)
    identity = np.eye(dimension)
    return tuple(sorted((t for t in found if not np.array_equal(t, identity)), key=lambda t: -np.linalg.det(t)))


def axes_in_words(turn: FloatArray, other: str) -> str:
    """`its x is the base's y, its y the base's −x, ...` for the axes (columns) of a turned frame."""
    words = []
    for column in range(len(turn)):
        row = int(np.argmax(np.abs(turn[:, column])))
        sign = "−" if turn[row, column] < 0.0 else ""
        words.append(f"its {'xyz'[column]} {'is ' if column == 0 else ''}the {other}'s {sign}{'xyz'[row]}")
    return ", ".join(words)


def _on_axes(turn: FloatArray, rotations: int) -> FloatArray:
    """What a turn (d, d) does to translations and rotations together; rotations are axial vectors, (n, n)."""
    dimension, sign = len(turn), float(np.linalg.det(turn))
    axial = sign * turn if rotations == dimension else np.full((rotations, rotations), sign)
    whole = np.zeros((dimension + rotations,) * 2)
    whole[:dimension, :dimension] = turn
    whole[dimension:, dimension:] = axial
    return whole


def turned_readings(sample: Hypothesis, turn: FloatArray, axes: IntArray, rotations: int) -> Hypothesis | None:
    """The readings in the base frame, `turn` having the instrument's axes as columns; None where one was not measured.

    Args:
        sample: readings in the instrument's axes.
        turn: shape (d, d).
        axes: measured axes (k,).
        rotations: how many axes of rotation there are.
    """
    whole = _on_axes(turn, rotations)
    if np.any(whole[np.ix_(axes, np.setdiff1d(np.arange(len(whole)), axes))]):
        return None
    own = whole[np.ix_(axes, axes)]
    deviations = None if sample.deviations is None else sample.deviations @ np.abs(own).T
    return replace(sample, readings=sample.readings @ own.T, deviations=deviations)


class WrongInstrumentFrame(Mistake):
    """The instrument's axes are not those of the base."""

    def alternatives(self, evidence: Evidence) -> Iterator[Alternative]:
        coordinates = evidence.robot.coordinates
        for turn in axis_turns(coordinates.translations):
            sample = turned_readings(evidence.stated, turn, evidence.axes, coordinates.rotations)
            if sample is None:
                continue
            turned = float(np.linalg.det(turn)) > 0.0
            what = "turned" if turned else "left-handed"
            text = f"Is the instrument's frame {what} ({axes_in_words(turn, 'base')})? Write the readings along x, y, z"
            yield Alternative(f"{text} of the base frame.", sample)


class LoadFrame(Mistake):
    """Centres of mass in a turned platform frame; forces and moments in a turned base frame, or in the platform's."""

    def alternatives(self, evidence: Evidence) -> Iterator[Alternative]:
        stated, coordinates = evidence.stated, evidence.robot.coordinates
        dimension, payload = coordinates.translations, evidence.recordings.payload
        for turn in axis_turns(dimension):
            if np.linalg.det(turn) < 0.0:
                continue
            if payload is None:
                whole = _on_axes(turn, coordinates.rotations)
                text = f"Are forces and moments in a turned frame ({axes_in_words(turn, 'base')})?"
                yield Alternative(text, replace(stated, wrenches=stated.wrenches @ whole.T))
            elif payload.shape[1] == 1 + dimension:
                centres = np.column_stack([payload[:, 0], payload[:, 1:] @ turn.T])
                text = f"Is the centre of mass in a turned frame ({axes_in_words(turn, 'platform')})?"
                yield Alternative(text, evidence.with_payload(centres))
        if payload is None and dimension == 3 and coordinates.rotations == 3:
            yield from self._places(evidence)

    def _places(self, evidence: Evidence) -> Iterator[Alternative]:
        """Forces and moments along the platform's axes, or moments about the base's origin."""
        stated, robot = evidence.stated, evidence.robot
        rotation = robot.jacobians(stated.configurations).rotation
        force, moment = stated.wrenches[:, :3, None], stated.wrenches[:, 3:, None]
        along = np.concatenate([rotation @ force, rotation @ moment], axis=1)[..., 0]
        text = "Are forces and moments along the axes of the platform? They have to be along those of the base."
        yield Alternative(text, replace(stated, wrenches=along))
        about = moment[..., 0] - np.cross(robot.position(stated.configurations), force[..., 0])
        text = "Are the moments about the origin of the base? They have to be about that of the platform."
        yield Alternative(text, replace(stated, wrenches=np.concatenate([force[..., 0], about], axis=1)))


class Gravity(Mistake):
    """Weights that pull along another axis of the base than the robot file says."""

    def alternatives(self, evidence: Evidence) -> Iterator[Alternative]:
        payload, gravity = evidence.recordings.payload, evidence.recordings.gravity
        if payload is None:
            return
        size = np.linalg.norm(gravity, axis=1, keepdims=True)
        for axis in range(gravity.shape[1]):
            for sign in (1.0, -1.0):
                other = sign * size * np.eye(gravity.shape[1])[axis]
                if not np.allclose(other, gravity, rtol=0.0, atol=0.1 * float(size.max(initial=0.0))):
                    text = f"Does gravity pull along the base's {'−' if sign < 0.0 else ''}{'xyz'[axis]}?"
                    remedy = "Correct `gravity_m_s2` in the robot file."
                    yield Alternative(f"{text} {remedy}", evidence.with_payload(payload, other))


class AngleOrder(Mistake):
    """The angles of the commands follow the other convention."""

    _CONVENTIONS: tuple[Orientation, ...] = ("fixed-xyz", "moving-xyz")

    def alternatives(self, evidence: Evidence) -> Iterator[Alternative]:
        robot, stated = evidence.robot, evidence.stated
        if robot.orientation is None or robot.configuration != robot.coordinates.pose:
            return
        angles = ca.SX.sym("angles", 3)
        for other in self._CONVENTIONS:
            if other == robot.orientation:
                continue
            meant = BatchFunction("meant", [angles], [angles_of(rotation_matrix(angles, other), robot.orientation)])
            turned = stated.configurations.copy()
            turned[:, 3:] = meant(stated.configurations[:, 3:])[0]
            if not np.isfinite(turned).all():
                continue
            text = f"Are the commanded angles those of `{other}`? The robot file says `{robot.orientation}`."
            yield Alternative(text, evidence.at(turned))
