"""Columns read otherwise: a matrix on the readings, the commands or the loads of all rows, with the question it asks.

Units and signs are diagonal, columns in each other's place permutations, frames turned by quarter turns or left-handed
both. Beside them the three mistakes that no matrix makes good: gravity, the place of moments and the order of angles.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from itertools import combinations, permutations, product

import casadi as ca
import numpy as np

from expdesign.arrays import BoolArray, FloatArray, TextArray
from expdesign.assurance.plausibility.evidence import Alternative, Evidence
from expdesign.chain.recordings.recordings import Recordings
from expdesign.io.units import UNITS, measured_column
from expdesign.mechanics.robots.orientation import Orientation, angles_of, rotation_matrix
from expdesign.mechanics.symbolic import BatchFunction

DEGREE = np.pi / 180.0
"""rad of a degree."""
_KGF = 9.80665
"""N of a kgf."""
_MOMENTS = (
    (1e-3, "Are moments in N·mm, or centres of mass in millimetres?"),
    (1e3, "Are moments in kN·m?"),
    (_KGF, "Are moments in kgf·m? 1 kgf = 9.80665 N."),
    (1.0 / _KGF, "Are the forces in kgf (1 kgf = 9.80665 N), and the moments in N·m?"),
    (-1.0, "Do the moments have the wrong sign?"),
)
_CONVENTIONS: tuple[Orientation, ...] = ("fixed-xyz", "moving-xyz")


def _scaled(columns: BoolArray, factor: float) -> FloatArray:
    """The matrix that multiplies some columns by a factor."""
    return np.diag(np.where(columns, factor, 1.0))


def _each(names: Sequence[str]) -> Iterator[tuple[str, BoolArray]]:
    """Every column alone."""
    return ((name, np.arange(len(names)) == column) for column, name in enumerate(names))


def signs(names: Sequence[str]) -> Iterator[tuple[str, FloatArray]]:
    """Every column: the question whether it has the wrong sign, and the matrix that turns it."""
    return ((f"Does {name} have the wrong sign?", _scaled(column, -1.0)) for name, column in _each(names))


def swaps(names: Sequence[str]) -> Iterator[tuple[str, FloatArray]]:
    """Every pair of columns of one unit: the question whether they are swapped, and the matrix that swaps them."""
    for first, second in combinations(range(len(names)), 2):
        if names[first].rsplit("_", 1)[-1] == names[second].rsplit("_", 1)[-1]:
            order = np.arange(len(names))
            order[[first, second]] = second, first
            yield f"Are the columns {names[first]} and {names[second]} swapped?", np.eye(len(names))[order]


def signs_of_readings(evidence: Evidence) -> Iterator[Alternative]:
    """Everything, one column, or all translations or rotations with the other sign."""
    linear, all_of_them = evidence.linear, np.ones(len(evidence.axes), dtype=bool)
    text = (
        "Do all deflections, or all loads, have the wrong sign? A deflection is the loaded minus the unloaded pose, "
        "and a load what the environment applies to the platform."
    )
    yield Alternative(text, evidence.readings(_scaled(all_of_them, -1.0)))
    yield from (Alternative(text, evidence.readings(matrix)) for text, matrix in signs(evidence.names))
    for kind, noun in ((linear, "translations"), (~linear, "rotations")):
        if kind.sum() > 1:
            yield Alternative(f"Do the {noun} have the wrong sign?", evidence.readings(_scaled(kind, -1.0)))


def units_of_readings(evidence: Evidence) -> Iterator[Alternative]:
    """Translations or rotations, or one column, in another unit; what is computed with has to be in m and rad.

    A column that is read smaller leaves less whatever is in it. One alone is in another unit only where it is nearer to
    what the robot file has it move in that unit: a drift of an axis that hardly moves is no mistake.
    """
    linear, names = evidence.linear, np.array(evidence.names)
    expected = (evidence.observation(evidence.recordings).sum(axis=2) ** 2).mean(axis=0)
    squares = (evidence.recordings.deflections**2).mean(axis=0)
    if linear.any() and (~linear).any():
        for factor, unit in ((1e-3, "mm"), (1e-6, "µm")):
            text = _in_unit(evidence, names[linear], factor, "the translations", unit)
            yield Alternative(text, evidence.readings(_scaled(linear, factor)))
        far = 1e9 * squares[linear].sum() <= expected[linear].sum()  # halfway from a thousand to a million
        unit, factor = ("µm", 1e6) if far else ("mm", 1e3)
        text = f"Are the translations in m, in columns that are named for {unit}? Name them `dx_m` ... then."
        yield Alternative(text, evidence.readings(_scaled(linear, factor)))
        for factor, unit in ((DEGREE, "deg"), (1e-3, "mrad"), (1e-6, "µrad")):
            text = _in_unit(evidence, names[~linear], factor, "the rotations", unit)
            yield Alternative(text, evidence.readings(_scaled(~linear, factor)))
        text = "Were the rotations converted from degrees twice?"
        yield Alternative(text, evidence.readings(_scaled(~linear, 1.0 / DEGREE)))
    for index, (name, column) in enumerate(_each(evidence.names)):
        for factor, unit in ((1e-3, "mm"), (1e-6, "µm")) if linear[index] else ((DEGREE, "deg"),):
            if squares[index] * factor >= expected[index]:
                text = _in_unit(evidence, names[[index]], factor, name, unit)
                yield Alternative(text, evidence.readings(_scaled(column, factor)))
        for factor, unit in ((1e3, "mm, or in mm in one for µm"), (1e6, "µm")) if linear[index] else ():
            if squares[index] * factor <= expected[index]:
                # With its standard deviation it would count for nothing, and any column would fit.
                larger = replace(evidence.readings(_scaled(column, factor)), deviations=evidence.recordings.deviations)
                yield Alternative(f"Is {name} in m in a column that is named for {unit}?", larger)


def _in_unit(evidence: Evidence, names: TextArray, factor: float, noun: str, unit: str) -> str:
    """The question whether columns are in another unit than the one that they are named for, smaller by a factor.

    Args:
        evidence: with the names in the file.
        names: of the columns, in SI.
        factor: by which they are too large.
        noun: what they are.
        unit: the other unit of columns that are in SI.
    """
    written = [evidence.recordings.written.get(name, name) for name in names.tolist()]
    stated = [measured_column(name) for name in written]
    example = names[0].rpartition("_")[0]
    if stated[0] is not None and not stated[0].is_si:
        own, example = stated[0], stated[0].base
        size = float(own.unit.factor) * factor
        like = (one for one in UNITS.values() if one.dimension == own.unit.dimension)
        found = next((one.name for one in like if np.isclose(float(one.factor), size, rtol=1e-9)), None)
        if found is None or any(each is None or each.unit != own.unit for each in stated):
            return (
                f"Are numbers of {', '.join(written)} in a unit {1.0 / factor:.3g} times smaller than their names say?"
            )
        unit = re.sub("^u", "µ", found)
    if len(names) == 1:
        return f"Is {written[0]} in {_SPOKEN.get(unit, unit)}?"
    text = f"Are {noun} in {_SPOKEN.get(unit, unit)}?"
    return f"{text} Write the unit into the columns' names, as in `{example}_{unit}`."


_SPOKEN = {"deg": "degrees"}


def swapped_readings(evidence: Evidence) -> Iterator[Alternative]:
    """Two columns of readings of one kind."""
    return (Alternative(text, evidence.readings(matrix)) for text, matrix in swaps(evidence.names))


def moments(evidence: Evidence) -> Iterator[Alternative]:
    """Moments in N·mm or kN·m, or with the wrong sign."""
    coordinates = evidence.robot.coordinates
    moment = np.arange(coordinates.n) >= coordinates.translations
    for factor, text in _MOMENTS if moment.any() else ():
        yield Alternative(text, _wrenches(evidence, _scaled(moment, factor)))


def _wrenches(evidence: Evidence, matrix: FloatArray) -> Recordings:
    """The loads of every row times a matrix (n, n)."""
    return replace(evidence.recordings, wrenches=evidence.recordings.wrenches @ matrix.T)


def units_of_commands(evidence: Evidence) -> Iterator[Alternative]:
    """Angles of a pose in degrees."""
    names = evidence.robot.configuration
    angles = np.array([name.endswith("_rad") for name in names])
    if names == evidence.robot.coordinates.pose and len(angles) > evidence.robot.coordinates.translations:
        degrees = evidence.recordings.configurations @ _scaled(angles, DEGREE)
        yield Alternative("Are the commanded angles in degrees?", evidence.hung(configurations=degrees))


def swapped_loads(evidence: Evidence) -> Iterator[Alternative]:
    """Two coordinates of the centre of mass, of the force or of the moment; one of a centre with the other sign."""
    coordinates = evidence.robot.coordinates
    if evidence.recordings.payload is None:
        yield from (Alternative(text, _wrenches(evidence, matrix)) for text, matrix in swaps(coordinates.wrench))
    else:
        pairs = (*swaps(coordinates.centre_of_mass), *signs(coordinates.centre_of_mass))
        yield from (Alternative(text, evidence.centres(matrix)) for text, matrix in pairs)


def swapped_commands(evidence: Evidence) -> Iterator[Alternative]:
    """Two coordinates of the command, or one with the other sign, where that is more than a shift of all rows."""
    commands, names = evidence.recordings.configurations, evidence.robot.configuration
    for text, matrix in (*swaps(names), *signs(names)):
        other = commands @ matrix.T
        if np.ptp(other - commands, axis=0).any():
            yield Alternative(text, evidence.hung(configurations=other))


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


def instrument_frame(evidence: Evidence) -> Iterator[Alternative]:
    """The instrument's axes are not those of the base; turns that need an axis which was not measured are left out."""
    coordinates, axes = evidence.robot.coordinates, evidence.axes
    for turn in axis_turns(coordinates.translations):
        whole = _on_axes(turn, coordinates.rotations)
        if np.any(whole[np.ix_(axes, np.setdiff1d(np.arange(len(whole)), axes))]):
            continue
        what = "turned" if float(np.linalg.det(turn)) > 0.0 else "left-handed"
        text = f"Is the instrument's frame {what} ({axes_in_words(turn, 'base')})? Write the readings along x, y, z"
        yield Alternative(f"{text} of the base frame.", evidence.readings(whole[np.ix_(axes, axes)]))


def load_frame(evidence: Evidence) -> Iterator[Alternative]:
    """Centres of mass in a turned platform frame; forces and moments in a turned base frame, or in the platform's."""
    coordinates, payload = evidence.robot.coordinates, evidence.recordings.payload
    for turn in axis_turns(coordinates.translations):
        if np.linalg.det(turn) < 0.0:
            continue
        if payload is None:
            text = f"Are forces and moments in a turned frame ({axes_in_words(turn, 'base')})?"
            yield Alternative(text, _wrenches(evidence, _on_axes(turn, coordinates.rotations)))
        elif payload.shape[1] == 1 + len(turn):
            text = f"Is the centre of mass in a turned frame ({axes_in_words(turn, 'platform')})?"
            yield Alternative(text, evidence.centres(turn))
    if payload is None and coordinates.translations == 3 and coordinates.rotations == 3:
        yield from _places_of_loads(evidence)


def _places_of_loads(evidence: Evidence) -> Iterator[Alternative]:
    """Forces and moments along the platform's axes, or moments about the base's origin."""
    stated, robot = evidence.recordings, evidence.robot
    rotation = robot.jacobians(stated.configurations).rotation
    force, moment = stated.wrenches[:, :3, None], stated.wrenches[:, 3:, None]
    along = np.concatenate([rotation @ force, rotation @ moment], axis=1)[..., 0]
    text = "Are forces and moments along the axes of the platform? They have to be along those of the base."
    yield Alternative(text, replace(stated, wrenches=along))
    about = moment[..., 0] - np.cross(robot.position(stated.configurations), force[..., 0])
    text = "Are the moments about the origin of the base? They have to be about that of the platform."
    yield Alternative(text, replace(stated, wrenches=np.concatenate([force[..., 0], about], axis=1)))


def gravity(evidence: Evidence) -> Iterator[Alternative]:
    """Weights that pull along another axis of the base than the robot file says."""
    payload, stated = evidence.recordings.payload, evidence.recordings.gravity
    if payload is None:
        return
    size = np.linalg.norm(stated, axis=1, keepdims=True)
    for axis in range(stated.shape[1]):
        for sign in (1.0, -1.0):
            other = sign * size * np.eye(stated.shape[1])[axis]
            if not np.allclose(other, stated, rtol=0.0, atol=0.1 * float(size.max(initial=0.0))):
                text = f"Does gravity pull along the base's {'−' if sign < 0.0 else ''}{'xyz'[axis]}?"
                remedy = "Correct `gravity_m_s2` in the robot file."
                yield Alternative(f"{text} {remedy}", evidence.hung(gravity=np.broadcast_to(other, stated.shape)))


def angle_order(evidence: Evidence) -> Iterator[Alternative]:
    """The angles of the commands follow the other convention."""
    robot, stated = evidence.robot, evidence.recordings
    if robot.orientation is None or robot.configuration != robot.coordinates.pose:
        return
    angles = ca.SX.sym("angles", 3)
    for other in _CONVENTIONS:
        if other == robot.orientation:
            continue
        meant = BatchFunction("meant", [angles], [angles_of(rotation_matrix(angles, other), robot.orientation)])
        turned = stated.configurations.copy()
        turned[:, 3:] = meant(stated.configurations[:, 3:])[0]
        if np.isfinite(turned).all():
            text = f"Are the commanded angles those of `{other}`? The robot file says `{robot.orientation}`."
            yield Alternative(text, evidence.hung(configurations=turned))
