"""Where the instrument stands and markers sit, from positions and the nominal robot: the start of a fit.

A pose from measured points: rigid registration, and the covariance of the pose (theory.md 9.A).

N ≥ 3 points of an artefact on the platform, known in the platform frame, are measured in the base frame. The pose
that fits them best is found by the singular value decomposition (Kabsch 1976). To first order a point moves by
δt + δθ × (R·p), so that with B_i = [I, −[R·p_i]ₓ] and noise σ on every coordinate

    Cov(δt, δθ) = σ²·(Σ B_iᵀ·B_i)⁻¹,        δX = T·(δt, δθ) in pose coordinates.

Where the platform frame is not at the centroid of the points, translation and rotation errors are correlated.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from expdesign.arrays import FloatArray
from expdesign.chain.readings.position import MarkerPosition, turns
from expdesign.chain.recordings.recordings import Recordings
from expdesign.errors import InputError, NotIdentifiableError
from expdesign.mechanics.robots.orientation import angles_of_matrix, arrays_in_space, rotations_of
from expdesign.mechanics.robots.robot import Robot


def registered(points: FloatArray, measured: FloatArray) -> tuple[FloatArray, FloatArray]:
    """R (..., 3, 3) and position t of the platform frame (..., 3) that fit measured ≈ R·p + t in least squares.

    Args:
        points: in the platform frame (m), shape (N, 3).
        measured: in the base frame (m), shape (..., N, 3).
    """
    centre, middle = points.mean(axis=0), measured.mean(axis=-2)
    product = (points - centre).T @ (measured - middle[..., None, :])
    left, _, right = np.linalg.svd(product)
    # det = −1 would be a reflection: the least certain direction is turned round.
    flip = np.ones((*product.shape[:-2], 3))
    flip[..., 2] = np.sign(np.linalg.det(left @ right))
    rotation = (right.swapaxes(-1, -2) * flip[..., None, :]) @ left.swapaxes(-1, -2)
    position: FloatArray = middle - rotation @ centre
    return rotation, position


def motion_rows(levers: FloatArray) -> FloatArray:
    """B_i = [I, −[l_i]ₓ] of points at levers l (N, 3): their motion by a twist (δt, δθ), shape (N, 3, 6)."""
    rows = np.zeros((len(levers), 3, 6))
    rows[:, :, :3] = np.eye(3)
    rows[:, :, 3:] = np.cross(np.eye(3), levers[:, None, :]).swapaxes(-1, -2)
    return rows


def twist_covariance(points: FloatArray, deviation: float, rotation: FloatArray) -> FloatArray:
    """Covariance of (δt, δθ) in base axes (m², m·rad, rad²), shape (6, 6).

    Args:
        points: in the platform frame (m), shape (N, 3).
        deviation: standard deviation of every measured coordinate (m).
        rotation: R of the platform, shape (3, 3).

    Raises:
        InputError: the points do not determine an orientation.
    """
    rows = motion_rows(points @ rotation.T)
    information = np.einsum("nij,nik->jk", rows, rows)
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if len(points) < 3 or spread[1] < 1e-9 * max(float(spread[0]), 1e-300):
        remedy = "At least three points that do not lie on one line are needed."
        raise InputError("the points do not determine an orientation", remedy=remedy)
    covariance: FloatArray = deviation**2 * np.linalg.inv(information)
    return covariance


def pose_covariance(points: FloatArray, deviation: float, rotation: FloatArray, pose_rates: FloatArray) -> FloatArray:
    """Covariance of a measured pose in pose coordinates, shape (6, 6); `pose_rates` is T with Ẋ = T·η (6, 6)."""
    covariance: FloatArray = pose_rates @ twist_covariance(points, deviation, rotation) @ pose_rates.T
    return covariance


_ON_A_LINE = 1e-9
"""Ratio of the singular values of readings below which they lie on one line."""
_ALTERNATIONS = 200
_COMPLETE = 4
"""Rows with all coordinates from which the instrument is registered; others are then filled in as registered."""


def require_registration(recordings: Recordings) -> None:
    """Raise where the fitted readings are fewer than three points, or lie on one line: they place no instrument."""
    readings = recordings.deflections[~recordings.test][:, :3]
    readings = readings[np.isfinite(readings).any(axis=1)]
    complete = np.isfinite(readings).all(axis=1)
    if not complete.all() and complete.sum() < _COMPLETE:
        return  # single coordinates place it together, if they do
    readings = readings[complete]
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
    """Block coordinate descent: rigid registration of the instrument (Kabsch), then least squares for the places.

    Coordinates that were not read are those of the registration before (expectation-maximisation).
    """
    assert recordings.marker is not None
    placed = np.zeros((len(recordings), 0)) if reading.unplaced else recordings.deflections[:, :3]
    kept = ~recordings.test & np.isfinite(placed).any(axis=1)
    if not kept.any():
        own = len(reading.parameters) - _spans(reading)
        return np.concatenate(
            [np.zeros(own), _fixed_points(reading, robot, recordings, np.zeros((len(reading.names), 3)))]
        )
    configurations, index = recordings.configurations[kept], recordings.marker[kept]
    readings = recordings.deflections[kept][:, :3]
    seen = np.isfinite(readings)
    complete = seen.all(axis=1)
    positions, rotations = arrays_in_space(robot.position(configurations), robot.jacobians(configurations).rotation)
    known = [reading.places.get(name) for name in reading.names]
    places = np.array([np.zeros(3) if place is None else place for place in known])
    for step_number in range(_ALTERNATIONS):
        points = positions + np.einsum("nij,nj->ni", rotations, places[index])
        if reading.instrument is not None:
            turn, shift = rotations_of(reading.instrument[3:]), reading.instrument[:3]
        elif step_number == 0 and complete.sum() >= _COMPLETE:
            turn, shift = registered(readings[complete], points[complete])
        else:
            filled = readings if step_number else np.where(seen, readings, points)
            turn, shift = registered(filled, points)
        readings = np.where(seen, readings, (points - shift) @ turn)
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
    frame = [] if reading.instrument is not None else [*shift, *angles_of_matrix(turn)]
    found = [*frame, *(c for place, k in zip(places, known, strict=True) if k is None for c in place)]
    for name in reading.oriented:
        assert recordings.aim is not None
        turned = np.isfinite(recordings.deflections[kept][:, :6]).all(axis=1) & (index == reading.names.index(name))
        seen_on_tip = Rotation.from_matrix(rotations[turned].swapaxes(1, 2) @ turn @ recordings.aim[kept][turned])
        found += angles_of_matrix(seen_on_tip.mean().as_matrix()).tolist()
    return np.array([*found, *(_fixed_points(reading, robot, recordings, places) if reading.fixed else ())])


def _spans(reading: MarkerPosition) -> int:
    """Number of parameters of fixed points and gauges."""
    return sum(1 if name in reading.gauges else 3 for name in reading.fixed)


def _fixed_points(reading: MarkerPosition, robot: Robot, recordings: Recordings, places: FloatArray) -> FloatArray:
    """Places of fixed points and zeros of gauges for the nominal robot with markers at `places` (m, 3).

    Squares of distances are linear in c and ‖c‖²: d² − ‖x‖² = −2·xᵀc + ‖c‖². Where the markers keep too close to a
    plane the least c is taken.
    """
    assert recordings.marker is not None
    assert recordings.point is not None
    assert recordings.along is not None
    positions, rotations = arrays_in_space(
        robot.position(recordings.configurations), robot.jacobians(recordings.configurations).rotation
    )
    markers = positions + np.einsum("nij,nj->ni", rotations, places[recordings.marker])
    spans = {int(axis): recordings.deflections[:, i] for i, axis in enumerate(recordings.axes)}
    found: list[float] = []
    for number, name in enumerate(reading.fixed):
        gauge = name in reading.gauges
        read = spans.get(7 if gauge else 6, np.full(len(recordings), np.nan))
        mine = ~recordings.test & (recordings.point == number) & np.isfinite(read)
        x, d = markers[mine], read[mine]
        if gauge:
            found.append(float(((recordings.along[mine] * x).sum(axis=1) - d).mean()) if mine.any() else 0.0)
            continue
        matrix = np.column_stack([-2.0 * x, np.ones(len(x))])
        found += np.linalg.lstsq(matrix, d**2 - (x**2).sum(axis=1), rcond=1e-6)[0][:3].tolist()
    return np.array(found)


def registration_residuals(reading: MarkerPosition, robot: Robot, recordings: Recordings) -> FloatArray:
    """What the start of a reading leaves of the positions, in O (m), shape (N, 3)."""
    assert recordings.marker is not None
    frame = reading.start[:6] if reading.instrument is None else reading.instrument
    first = 0 if reading.instrument is not None else 6
    found = iter(reading.start[first : first + 3 * len(reading.unknown)].reshape(-1, 3))
    places = np.array([reading.places[name] if name in reading.places else next(found) for name in reading.names])
    configurations = recordings.configurations
    positions, rotations = arrays_in_space(robot.position(configurations), robot.jacobians(configurations).rotation)
    points = positions + np.einsum("nij,nj->ni", rotations, places[recordings.marker])
    residuals: FloatArray = recordings.deflections[:, :3] @ rotations_of(frame[3:]).T + frame[:3] - points
    return residuals
