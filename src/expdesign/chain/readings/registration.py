"""Where the instrument stands and markers sit, from positions and the nominal robot: the start of a fit."""

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.readings.position import MarkerPosition, turns
from expdesign.errors import NotIdentifiableError
from expdesign.moments import arrays_in_space
from expdesign.recordings.recordings import Recordings
from expdesign.robots.orientation import rotation_matrix
from expdesign.robots.robot import Robot

_ON_A_LINE = 1e-9
"""Ratio of the singular values of readings below which they lie on one line."""
_ALTERNATIONS = 200


def require_registration(recordings: Recordings) -> None:
    """Raise where the fitted readings are fewer than three points, or lie on one line: they place no instrument."""
    readings = recordings.deflections[~recordings.test]
    sizes = np.linalg.svd(readings - readings.mean(axis=0), compute_uv=False) if len(readings) > 2 else np.zeros(2)
    if sizes[1] <= _ON_A_LINE * sizes[0]:
        what = "the fitted positions do not tell where the instrument stands"
        remedy = "Record at least three that do not lie on one line, or give `instrument` in the robot file."
        raise NotIdentifiableError(what, where=recordings.source, remedy=remedy)


def held_coordinates(reading: MarkerPosition, robot: Robot, recordings: Recordings) -> tuple[tuple[str, str], ...]:
    """Coordinates of markers that the fitted rows do not tell from the instrument.

    One marker on a tip that does not turn shows the instrument, further markers then show what they differ by: only the
    first unknown one is held, and none where the place of another is known.
    """
    if reading.places or not reading.unknown:
        return ()
    values, axes = np.linalg.eigh(turns(robot, recordings)[1])
    held: list[str] = []
    for value, axis in zip(values, axes.T, strict=True):
        if value > 0.5:
            order = np.argsort(-np.abs(axis))
            held.append(next("xyz"[i] for i in order if "xyz"[i] not in held))
    return tuple((reading.unknown[0], axis) for axis in sorted(held))


def start_of(reading: MarkerPosition, robot: Robot, recordings: Recordings) -> FloatArray:
    """Block coordinate descent: rigid registration of the instrument (Kabsch), then least squares for the places."""
    kept = ~recordings.test
    assert recordings.marker is not None
    configurations, index = recordings.configurations[kept], recordings.marker[kept]
    readings = recordings.deflections[kept]
    positions, rotations = arrays_in_space(robot.position(configurations), robot.jacobians(configurations).rotation)
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


def registration_residuals(reading: MarkerPosition, robot: Robot, recordings: Recordings) -> FloatArray:
    """What the start of a reading leaves of the positions, in O (m), shape (N, 3)."""
    assert recordings.marker is not None
    frame = reading.start[:6] if reading.instrument is None else reading.instrument
    found = iter(reading.start[0 if reading.instrument is not None else 6 :].reshape(-1, 3))
    places = np.array([reading.places[name] if name in reading.places else next(found) for name in reading.names])
    configurations = recordings.configurations
    positions, rotations = arrays_in_space(robot.position(configurations), robot.jacobians(configurations).rotation)
    points = positions + np.einsum("nij,nj->ni", rotations, places[recordings.marker])
    residuals: FloatArray = recordings.deflections @ _rotation(frame[3:]).T + frame[:3] - points
    return residuals


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
