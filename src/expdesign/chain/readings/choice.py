"""The reading that recordings are of: the one place where it is chosen."""

from dataclasses import replace

import numpy as np

from expdesign.chain.readings.position import MarkerPosition
from expdesign.chain.readings.reading import DEFLECTION, MeasuredPose, Reading
from expdesign.chain.readings.registration import held_coordinates, require_registration, start_of
from expdesign.chain.recordings.recordings import LoadedPoints, Recordings
from expdesign.errors import InputError
from expdesign.mechanics.robots.robot import Robot


def _oriented(points: LoadedPoints) -> tuple[str, ...]:
    """Markers of which an orientation was read in a fitted row."""
    if points.aim is None or not isinstance(points, Recordings):
        return ()
    turns = np.flatnonzero((points.axes >= 3) & (points.axes < 6))
    seen = np.isfinite(points.deflections[:, turns]).any(axis=1) & ~points.test
    sites = points.sites or points.markers
    read = [site for index, site in enumerate(sites) if (seen & (points.marker == index)).any()]
    return tuple(dict.fromkeys(read))


def reading_of(robot: Robot, points: LoadedPoints, *, frames_known: bool = True) -> Reading:
    """What points read, with a start of the unknown parameters.

    Args:
        robot: the robot.
        points: commands, loads and what was measured.
        frames_known: whether measured poses are in the very frames of the commands.

    Raises:
        InputError: markers are on a platform that has no orientation.
        NotIdentifiableError: the instrument's pose is unknown and the fitted positions do not determine it.
    """
    if not points.measurand.absolute:
        return DEFLECTION
    if points.poses:
        if not frames_known and robot.orientation is None:
            what = f"frames that are unknown need a robot with six pose coordinates, and this is a {robot.kind}"
            raise InputError(what, where=points.source, remedy="Leave argument `frames=unknown` out.")
        return MeasuredPose(frames_known)
    if robot.coordinates.rotations == 0 and robot.on_legs:
        what = f"marker positions are not supported for a {robot.kind}, whose platform has no orientation"
        raise InputError(what, where=points.source, remedy="Convert them to deflections.")
    places = {name: place for name, place in robot.markers.items() if name in (points.sites or points.markers)}
    gauged = (
        () if points.along is None or points.point is None else np.unique(points.point[np.any(points.along, axis=1)])
    )
    unplaced = isinstance(points, Recordings) and points.point is not None and 0 not in points.axes
    reading = MarkerPosition(
        points.markers,
        places,
        np.zeros(6) if unplaced else robot.instrument,
        np.zeros(0),
        oriented=_oriented(points),
        fixed=points.fixed,
        gauges=tuple(points.fixed[int(index)] for index in gauged),
        unplaced=unplaced,
        sites=points.sites,
        stations=points.stations,
    )
    if len(reading.standing) > 1 and robot.instrument is not None:
        what = f"the instrument has {len(reading.standing)} stations, and the robot file gives one pose of it"
        raise InputError(what, where=points.source, remedy="Take `instrument` out of the robot file.")
    if not isinstance(points, Recordings):
        return replace(reading, start=np.zeros(len(reading.parameters)))
    if reading.instrument is None:
        require_registration(points)
        reading = replace(reading, held=held_coordinates(reading, robot, points))
    return replace(reading, start=start_of(reading, robot, points))
