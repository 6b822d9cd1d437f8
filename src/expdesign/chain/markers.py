"""The reading of an instrument that measures where markers are: a laser tracker, a total station, motion capture.

The chain ends with the position of a marker in the instrument's axes,

    y = R_Iᵀ·(p(q; geometry) + δp + Rot(δφ)·R(q; geometry)·m − t_I),

p and R being the tip's pose as geometry alone has it, (δp, δφ) its deflection, m the marker's place on the tip and
(t_I, R_I) the instrument's pose in O. Marker and instrument are parameters of every model, the base model included,
unless the robot file gives them.

A tool that keeps one orientation shows only p + R·m − t_I: the marker's place along an axis of the tip that never turns
cannot be told from the instrument's. Orientations that vary by less than geometry is uncertain by anyway tell nothing
either, however small the noise; such coordinates are `held` at the tip's origin, and what depends on them is not known.
"""

from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.errors import InputError, NotIdentifiableError
from expdesign.recordings.recordings import LoadedPoints, Recordings
from expdesign.robots.bipod import Bipod
from expdesign.robots.body import Body
from expdesign.robots.hexapod import Hexapod
from expdesign.robots.orientation import rotation_matrix
from expdesign.robots.robot import Robot
from expdesign.robots.serial import SerialRobot

SMALLEST_TURN = 0.02
"""rad (RMS); a tip that turns by less, as links may be misaligned, does not tell a marker from the instrument."""
_HELD = 1e-6
"""m; standard deviation of a coordinate that is held."""
_ON_A_LINE = 1e-9
"""Ratio of the singular values of readings below which they lie on one line."""
MARKER_SPREAD = 1.0
"""m; standard deviation of a marker's place on the tip before anything is measured."""
COMPLIANCE_SPREAD = 3.0
"""Standard deviation of a compliance in units of the robot file's before anything is measured."""
_AXES = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")
_ALTERNATIONS = 200


@dataclass(frozen=True)
class MarkerReading:
    """What the readings of a file are of, and what of it is unknown.

    Attributes:
        names: the markers, in the order of `Row.marker`.
        places: known places on the tip (m), shape (3,) each, by name.
        instrument: the instrument's known pose in O (m, rad), shape (6,), or None.
        start: of the unknown parameters, in the order of `parameters`.
        held: coordinates of markers that are held at the tip's origin, e.g. `("prism", "x")`.
    """

    names: tuple[str, ...]
    places: dict[str, FloatArray]
    instrument: FloatArray | None
    start: FloatArray
    held: tuple[tuple[str, str], ...] = ()

    @property
    def unknown(self) -> tuple[str, ...]:
        """Markers whose places are estimated."""
        return tuple(name for name in self.names if name not in self.places)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The instrument's pose, then the places of the markers, where they are unknown."""
        frame = () if self.instrument is not None else tuple(Parameter(f"instrument {a}", 1e-2) for a in _AXES)
        return frame + tuple(
            Parameter(f"marker {name} {axis}_m", 1e-2, spread=_HELD if (name, axis) in self.held else MARKER_SPREAD)
            for name in self.unknown
            for axis in "xyz"
        )

    @property
    def degeneracies(self) -> list[str]:
        """What cannot be told apart, in sentences."""
        sentences = []
        for name in self.unknown:
            axes = [axis for marker, axis in self.held if marker == name]
            if axes:
                listed = "its place" if len(axes) == 3 else f"its place along {' and '.join(axes)} of the tip"
                sentences.append(
                    f"In the fitted rows the tip keeps one orientation, as far as marker `{name}` is concerned: "
                    f"{listed} cannot be told from that of the instrument, and is taken to be the tip's origin. Rows "
                    "in which the tip is turned otherwise cannot be predicted, and are not judged; give the marker's "
                    "place in the robot file, or record more orientations."
                )
        return sentences

    def predictable(self, robot: Robot, recordings: Recordings) -> BoolArray:
        """Rows in which nothing that is held shows: the tip is turned as in the fitted rows, shape (N,)."""
        if not self.held:
            return np.ones(len(recordings), dtype=bool)
        differences, fixed = _turns(robot, recordings)
        turned = np.linalg.norm(differences @ fixed, axis=(1, 2))
        within: BoolArray = turned <= max(2.0 * float(turned[~recordings.test].max()), 1e-9)
        return within

    def expression(self, robot: Robot, deflection: ca.SX, row: Row, theta: ca.SX, geometry: ca.SX | None) -> ca.SX:
        """Position (3,) of the row's marker in the instrument's axes; `geometry` holds a serial robot's errors."""
        frame = theta[:6] if self.instrument is None else ca.SX(self.instrument)
        offset = 6 if self.instrument is None else 0
        place = ca.SX.zeros(3)
        for index, name in enumerate(self.names):
            if name in self.places:
                own = ca.SX(self.places[name])
            else:
                start = offset + 3 * self.unknown.index(name)
                own = theta[start : start + 3]
            place += row.marker[index] * own
        position, rotation = displaced(robot, deflection, row, geometry)
        return rotation_matrix(frame[3:6], "fixed-xyz").T @ (position + rotation @ place - frame[:3])


def _turns(robot: Robot, recordings: Recordings) -> tuple[FloatArray, FloatArray]:
    """R − R̄ of every row (N, 3, 3), R̄ being the mean of the fitted rows, and which axes of the tip that leaves fixed.

    The second is a projector (3, 3) onto directions of the tip that the fitted rows turn by less than `SMALLEST_TURN`.
    """
    rotations = robot.jacobians(recordings.configurations).rotation
    kept = ~recordings.test
    differences = rotations - rotations[kept].mean(axis=0)
    _, sizes, axes = np.linalg.svd(differences[kept].reshape(-1, 3) / np.sqrt(int(kept.sum())))
    fixed = axes[sizes < SMALLEST_TURN]
    return differences, fixed.T @ fixed


def displaced(robot: Robot, deflection: ca.SX, row: Row, geometry: ca.SX | None) -> tuple[ca.SX, ca.SX]:
    """Position and orientation of the tip with its deflection (to second order in its rotation)."""
    if isinstance(robot, SerialRobot):
        position, rotation = robot.tip(row.pose, geometry)
        turn = ca.skew(deflection[3:])
        return position + deflection[:3], (ca.SX.eye(3) + turn + 0.5 * (turn @ turn)) @ rotation
    assert isinstance(robot, Hexapod | Body)
    pose = row.pose + deflection
    return ca.SX(robot.home) + pose[:3], robot.rotation(pose)


def reading_of(robot: Robot, points: LoadedPoints) -> MarkerReading | None:
    """What position recordings read, with a start of the unknown parameters; None for deflections.

    Raises:
        InputError: the robot is of a kind whose platform has no orientation.
        NotIdentifiableError: the instrument's pose is unknown and the fitted positions do not determine it.
    """
    if points.marker is None:
        return None
    if isinstance(robot, Bipod):
        what = "marker positions are not supported for a bipod"
        raise InputError(what, where=points.source, remedy="Convert them to deflections.")
    places = {name: place for name, place in robot.markers.items() if name in points.markers}
    reading = MarkerReading(points.markers, places, robot.instrument, np.zeros(0))
    if not isinstance(points, Recordings):
        return replace(reading, start=np.zeros(len(reading.parameters)))
    if robot.instrument is None:
        _require_registration(points)
        reading = replace(reading, held=_held(reading, robot, points))
    return replace(reading, start=_start(reading, robot, points))


def _require_registration(recordings: Recordings) -> None:
    """Raise where the fitted readings are fewer than three points, or lie on one line: they place no instrument."""
    readings = recordings.deflections[~recordings.test]
    sizes = np.linalg.svd(readings - readings.mean(axis=0), compute_uv=False) if len(readings) > 2 else np.zeros(2)
    if sizes[1] <= _ON_A_LINE * sizes[0]:
        what = "the fitted positions do not tell where the instrument stands"
        remedy = "Record at least three that do not lie on one line, or give `instrument` in the robot file."
        raise NotIdentifiableError(what, where=recordings.source, remedy=remedy)


def _held(reading: MarkerReading, robot: Robot, recordings: Recordings) -> tuple[tuple[str, str], ...]:
    """Coordinates of markers that the fitted rows do not tell from the instrument.

    One marker on a tip that does not turn shows the instrument, further markers then show what they differ by: only the
    first unknown one is held, and none where the place of another is known.
    """
    if reading.places or not reading.unknown:
        return ()
    values, axes = np.linalg.eigh(_turns(robot, recordings)[1])
    held: list[str] = []
    for value, axis in zip(values, axes.T, strict=True):
        if value > 0.5:
            order = np.argsort(-np.abs(axis))
            held.append(next("xyz"[i] for i in order if "xyz"[i] not in held))
    return tuple((reading.unknown[0], axis) for axis in sorted(held))


def _start(reading: MarkerReading, robot: Robot, recordings: Recordings) -> FloatArray:
    """Instrument and markers by turns: rigid registration (Kabsch), then linear least squares for the places."""
    kept = ~recordings.test
    assert recordings.marker is not None
    configurations, index = recordings.configurations[kept], recordings.marker[kept]
    readings = recordings.deflections[kept]
    positions = robot.position(configurations)
    rotations = robot.jacobians(configurations).rotation
    known = [reading.places.get(name) for name in reading.names]
    places = np.array([np.zeros(3) if place is None else place for place in known])
    for _ in range(_ALTERNATIONS):
        points = positions + np.einsum("nij,nj->ni", rotations, places[index])
        if reading.instrument is None:
            turn, shift = _registration(points, readings)
        else:
            turn = _rotation(reading.instrument[3:])
            shift = reading.instrument[:3]
        in_base = readings @ turn.T + shift
        for k, place in enumerate(known):
            mine = index == k
            if place is None and mine.any():
                differences = (in_base - points)[mine]
                free = [i for i, axis in enumerate("xyz") if (reading.names[k], axis) not in reading.held]
                columns = rotations[mine].reshape(-1, 3)[:, free]
                shared = np.tile(np.eye(3), (int(mine.sum()), 1))
                matrix = np.hstack([columns, shared]) if reading.instrument is None else columns
                step = np.linalg.lstsq(matrix, differences.ravel(), rcond=1e-6)[0]
                places[k, free] += step[: len(free)]
    frame = [] if reading.instrument is not None else [*shift, *_angles(turn)]
    return np.array([*frame, *(c for place, k in zip(places, known, strict=True) if k is None for c in place)])


def _registration(points: FloatArray, readings: FloatArray) -> tuple[FloatArray, FloatArray]:
    """R_I and t_I with points ≈ R_I·reading + t_I in the least-squares sense (Kabsch 1976)."""
    centre, middle = points.mean(axis=0), readings.mean(axis=0)
    left, _, right = np.linalg.svd((points - centre).T @ (readings - middle))
    sign = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    turn: FloatArray = left @ sign @ right
    return turn, centre - turn @ middle


def _rotation(angles: FloatArray) -> FloatArray:
    return np.array(ca.DM(rotation_matrix(ca.SX(angles), "fixed-xyz")))


def _angles(turn: FloatArray) -> FloatArray:
    """(rx, ry, rz) of R = Rz·Ry·Rx."""
    return np.array(
        [
            np.arctan2(turn[2, 1], turn[2, 2]),
            -np.arcsin(np.clip(turn[2, 0], -1.0, 1.0)),
            np.arctan2(turn[1, 0], turn[0, 0]),
        ]
    )


def true_geometry(robot: Robot, effects: tuple[Effect, ...], parts: list[ca.SX]) -> ca.SX | None:
    """Geometric errors of a serial robot with the effects that change them, or None where there are none."""
    if not isinstance(robot, SerialRobot):
        return None
    nominal = ca.SX.zeros(robot.tree.size)
    geometry = nominal
    for effect, part in zip(effects, parts, strict=True):
        geometry = effect.geometry(geometry, part)
    return None if geometry is nominal else geometry
