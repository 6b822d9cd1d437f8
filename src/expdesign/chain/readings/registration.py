"""Where the instrument stands and markers sit, from positions and the nominal robot: the start of a fit.

A pose from measured points: rigid registration, and the covariance of the pose (theory.md 9.A).

N ≥ 3 points of an artefact on the platform, known in the platform frame, are measured in the base frame. The pose
that fits them best is found by the singular value decomposition (Kabsch 1976). To first order a point moves by
δt + δθ × (R·p), so that with B_i = [I, −[R·p_i]ₓ] and noise σ on every coordinate

    Cov(δt, δθ) = σ²·(Σ B_iᵀ·B_i)⁻¹,        δX = T·(δt, δθ) in pose coordinates.

Where the platform frame is not at the centroid of the points, translation and rotation errors are correlated.
"""

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.readings.position import FIXED, INSTRUMENT, PLACE, TURN, MarkerPosition, turns
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
_STANDING = 1e-10
"""m; a change of every place below which they have settled."""
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
    found: list[tuple[str, str]] = []
    for rows in reading.by_station(recordings):
        sites = [reading.sited[i] for i in np.unique(np.asarray(recordings.marker)[rows])]
        if not (rows & ~recordings.test).any() or any(site == each for site in sites for each, _ in found):
            continue
        values, axes = np.linalg.eigh(turns(robot, recordings.rows(rows))[1])
        held: list[str] = []
        for value, axis in zip(values, axes.T, strict=True):
            if value > 0.5:
                order = np.argsort(-np.abs(axis))
                held.append(next("xyz"[i] for i in order if "xyz"[i] not in held))
        first = next(site for site in reading.unknown if site in sites)
        found += [(first, axis) for axis in sorted(held)]
    return tuple(found)


def start_of(reading: MarkerPosition, robot: Robot, recordings: Recordings) -> FloatArray:
    """Block coordinate descent: rigid registration of the instrument (Kabsch), then least squares for the places.

    Coordinates that were not read are those of the registration before (expectation-maximisation).
    """
    assert recordings.marker is not None
    placed = np.zeros((len(recordings), 0)) if reading.unplaced else recordings.deflections[:, :3]
    kept = ~recordings.test & np.isfinite(placed).any(axis=1)
    if not kept.any():
        return _with_fixed(reading, robot, recordings, np.zeros(len(reading.parameters)))
    configurations, index = recordings.configurations[kept], recordings.marker[kept]
    readings = recordings.deflections[kept][:, :3]
    seen = np.isfinite(readings)
    complete = seen.all(axis=1)
    positions, rotations = arrays_in_space(robot.position(configurations), robot.jacobians(configurations).rotation)
    sites = list(dict.fromkeys(reading.sited))
    site = np.array([sites.index(each) for each in reading.sited])[index]
    at = np.array([reading.standing.index(each) for each in reading.seen_from])[index]
    known = [reading.places.get(name) for name in sites]
    places = np.array([np.zeros(3) if place is None else place for place in known])
    turns_by, shifts = np.tile(np.eye(3), (len(reading.standing), 1, 1)), np.zeros((len(reading.standing), 3))
    if reading.instrument is not None:
        turns_by[:], shifts[:] = rotations_of(reading.instrument[3:]), reading.instrument[:3]
    stations = np.unique(at) if reading.instrument is None else ()
    steps = _steps(rotations, at, site, sites, reading)
    for step_number in range(_ALTERNATIONS):
        points = positions + np.einsum("nij,nj->ni", rotations, places[site])
        for station in stations:
            mine = at == station
            if step_number == 0 and (complete & mine).sum() >= _COMPLETE:
                mine &= complete
            filled = readings if step_number else np.where(seen, readings, points)
            turns_by[station], shifts[station] = registered(filled[mine], points[mine])
        turn, shift = turns_by[at], shifts[at]
        readings = np.where(seen, readings, np.einsum("nji,nj->ni", turn, points - shift))
        in_base, before = np.einsum("nij,nj->ni", turn, readings) + shift, places.copy()
        for k, (mine, free, solution) in steps.items():
            places[k, free] += solution @ (in_base - points)[mine].ravel()
        if complete.all() and step_number and np.abs(places - before).max(initial=0.0) < _STANDING:
            break
    start = np.zeros(len(reading.parameters))
    if reading.instrument is None:
        for station, turned, shifted in zip(reading.standing, turns_by, shifts, strict=True):
            start[reading.parts[INSTRUMENT, station]] = *shifted, *angles_of_matrix(turned)
    for name in reading.unknown:
        start[reading.parts[PLACE, name]] = places[sites.index(name)]
    for name in reading.oriented:
        from scipy.spatial.transform import Rotation  # noqa: PLC0415 (slow to import, and few need it)

        assert recordings.aim is not None
        aimed = np.isfinite(recordings.deflections[kept][:, :6]).all(axis=1) & (site == sites.index(name))
        on_tip = rotations[aimed].swapaxes(1, 2) @ turn[aimed] @ recordings.aim[kept][aimed]
        start[reading.parts[TURN, name]] = angles_of_matrix(Rotation.from_matrix(on_tip).mean().as_matrix())
    return _with_fixed(reading, robot, recordings, start)


def _steps(
    rotations: FloatArray, at: IntArray, site: IntArray, sites: list[str], reading: MarkerPosition
) -> dict[int, tuple[BoolArray, list[int], FloatArray]]:
    """By unknown site: rows that see it, its free axes, and the least squares of its step from their differences."""
    found = {}
    for k, name in enumerate(sites):
        mine = site == k
        if name in reading.places or not mine.any():
            continue
        free = [i for i, axis in enumerate("xyz") if (name, axis) not in reading.held]
        columns = rotations[mine].reshape(-1, 3)[:, free]
        # Every station that sees the marker may be shifted with its place.
        shared = np.kron(at[mine][:, None] == np.unique(at[mine]), np.eye(3))
        matrix = np.hstack([columns, shared]) if reading.instrument is None else columns
        found[k] = mine, free, np.linalg.pinv(matrix, rcond=1e-6)[: len(free)]
    return found


def _with_fixed(reading: MarkerPosition, robot: Robot, recordings: Recordings, start: FloatArray) -> FloatArray:
    """Parameters with the places of fixed points and the zeros of gauges for the nominal robot and these markers.

    Squares of distances are linear in c and ‖c‖²: d² − ‖x‖² = −2·xᵀc + ‖c‖². Where the markers keep too close to a
    plane the least c is taken.
    """
    if not reading.fixed:
        return start
    assert recordings.marker is not None
    assert recordings.point is not None
    assert recordings.along is not None
    markers = _markers(reading, robot, recordings, start)
    spans = {int(axis): recordings.deflections[:, i] for i, axis in enumerate(recordings.axes)}
    for number, name in enumerate(reading.fixed):
        gauge, own = name in reading.gauges, reading.parts[FIXED, name]
        read = spans.get(7 if gauge else 6, np.full(len(recordings), np.nan))
        mine = ~recordings.test & (recordings.point == number) & np.isfinite(read)
        x, d = markers[mine], read[mine]
        if gauge:
            start[own] = ((recordings.along[mine] * x).sum(axis=1) - d).mean() if mine.any() else 0.0
            continue
        matrix = np.column_stack([-2.0 * x, np.ones(len(x))])
        start[own] = np.linalg.lstsq(matrix, d**2 - (x**2).sum(axis=1), rcond=1e-6)[0][:3]
    return start


def _markers(reading: MarkerPosition, robot: Robot, recordings: Recordings, start: FloatArray) -> FloatArray:
    """Where the nominal robot has the marker of every row, in O (m), shape (N, 3)."""
    configurations = recordings.configurations
    positions, rotations = arrays_in_space(robot.position(configurations), robot.jacobians(configurations).rotation)
    found: FloatArray = positions + np.einsum("nij,nj->ni", rotations, reading.marked(start)[recordings.marker])
    return found


def registration_residuals(reading: MarkerPosition, robot: Robot, recordings: Recordings) -> FloatArray:
    """What the start of a reading leaves of the positions, in O (m), shape (N, 3)."""
    assert recordings.marker is not None
    frames = reading.frames(reading.start)[recordings.marker]
    points = _markers(reading, robot, recordings, reading.start)
    turned = np.einsum("nij,nj->ni", rotations_of(frames[:, 3:]), recordings.deflections[:, :3])
    residuals: FloatArray = turned + frames[:, :3] - points
    return residuals
