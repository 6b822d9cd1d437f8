"""Read recordings and points from tables; faults name file, row and column (file-formats.md, Recordings)."""

import logging
from pathlib import Path

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.recordings.columns import (
    order_in_time,
    read_sequence,
    read_test_rows,
    read_time,
    require_one_command,
)
from expdesign.chain.recordings.filled_in import filled_in
from expdesign.chain.recordings.join import join
from expdesign.chain.recordings.joint_columns import require_its_own, with_joint_columns
from expdesign.chain.recordings.measurand import POSITION, POSITION_DEVIATION, measured_names
from expdesign.chain.recordings.measured_values import READERS
from expdesign.chain.recordings.pose_columns import measures_poses
from expdesign.chain.recordings.positions import read_markers
from expdesign.chain.recordings.recordings import LoadedPoints, Recordings
from expdesign.chain.recordings.references import REFERENCE, read_references, require_one_command_per_reference
from expdesign.chain.recordings.spans import ALONG, POINT, SPAN_DEVIATIONS, SPANS, read_fixed
from expdesign.chain.recordings.target_readings import read_aims, with_targets
from expdesign.errors import InputError
from expdesign.io.table import Table, read_table
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.loads.payload import Payload
from expdesign.mechanics.robots.robot import Robot

_LOG = logging.getLogger(__name__)

LARGEST_ANGLE = 2.0 * np.pi
"""rad; a larger angle of a platform is in degrees."""
LARGEST_STRETCH = 10.0
"""A pose at which a leg is this many times longer than at the reference pose is in mm."""
CONTRADICTION = 0.01
"""Relative difference of a payload and a wrench that are both given, above which they contradict each other."""
LEVER = 0.05
"""m; moments below `CONTRADICTION` × force × this lever are not compared."""


def read_recordings(path: Path, robot: Robot) -> Recordings:
    """Recordings of a robot.

    Raises:
        InputError: the file is missing, or anything in it is missing, not a number, or cannot be right.
    """
    recordings = recordings_from_table(read_table(path), robot)
    require_measured(recordings, robot)
    return recordings


def read_points(path: Path, robot: Robot) -> LoadedPoints:
    """Points at which a prediction or a command is wanted; measured columns are ignored. Raises `InputError`."""
    return points_from_table(read_table(path), robot)


def points_from_table(table: Table, robot: Robot, *, measured: bool = False) -> LoadedPoints:
    """Points in a table; see `read_points`. Where they are to be `measured`, rows of a series share one command."""
    return _points(table, robot, measured=measured)


def read_several(paths: list[Path], robot: Robot) -> Recordings:
    """Recordings of a robot in one or more files, as if they stood in one.

    Sequence and series numbers that occur in more than one file are those of separate sessions and are counted on;
    numbers that do not overlap are those of one session that was written to several files.

    Raises:
        InputError: a file is wrong or is given twice, or the files do not have the same columns.
    """
    for index, path in enumerate(paths):
        if path.resolve() in [other.resolve() for other in paths[:index]]:
            raise InputError("this file is given twice", where=str(path), remedy="Name it once.")
    return join([read_recordings(path, robot) for path in paths])


def require_measured(recordings: Recordings, robot: Robot) -> None:
    """Raise an `InputError` where nothing deflects under load, as in a plan whose columns were filled with zeros."""
    if recordings.poses:
        return
    if len(robot.stiffness) and np.any(recordings.wrenches) and not np.any(recordings.deflections):
        what = "every deflection is 0, although there are loads"
        raise InputError(what, where=recordings.source, remedy="Fill in what was measured.")


def recordings_from_table(table: Table, robot: Robot) -> Recordings:
    """Recordings in a table; see `read_recordings`."""
    table.require(("sequence", "series"))
    table, notes = filled_in(with_targets(table, robot), robot.coordinates)
    if notes:
        _LOG.info("%s: %s", table.source, "; ".join(notes))
    points = _points(table, robot, measured=True)
    if len(robot.stiffness):
        require_one_command_per_reference(points)
    order = order_in_time(table)
    axes, deflections, deviations = READERS[points.measurand](table, points, robot.coordinates, order)
    return Recordings(
        **vars(points),
        axes=axes,
        deflections=deflections,
        deviations=deviations,
        test=read_test_rows(table, order),
    )


def _points(table: Table, robot: Robot, *, measured: bool) -> LoadedPoints:
    table = with_targets(with_joint_columns(table, robot), robot)
    require_its_own(table, robot)
    order = order_in_time(table)
    coordinates = robot.coordinates
    configurations = table.numbers(robot.configuration)[order]
    _sensible_poses(table, robot, configurations, order)
    sequence = read_sequence(table)[order]
    series = table.integers("series")[order] if table.has("series") else sequence
    time = read_time(table, order)
    marker, markers = read_markers(table, order)
    poses = measures_poses(table, robot)
    point, fixed, along = read_fixed(table, order) if markers and robot.links is not None else (None, (), None)
    if measured and len(robot.stiffness) and not markers and not poses:
        # A body has no actuators: its pose says where it is, and is not a command that a series shares.
        require_one_command(table, robot.configuration, configurations, series, order)
    gravity = np.broadcast_to(robot.gravity, (len(table), len(robot.gravity))).copy()
    for i, name in enumerate(coordinates.gravity):
        if table.has(name):
            gravity[:, i] = table.numbers((name,))[order, 0]
    payload = _payload(table, robot, order)
    unloaded = payload is None and not any(table.has(name) for name in coordinates.wrench)
    # Deflections need a load; absolute readings show the weight of what is there.
    unloaded &= poses or bool(markers) or (robot.links is not None and not measured)
    load = (table, robot, configurations, payload, gravity, order)
    wrenches = np.zeros((len(table), coordinates.n)) if unloaded else _wrenches(*load)
    absolute = wrenches.copy()
    absolute_names = tuple(f"abs_{name}" for name in coordinates.wrench)
    if any(table.has(name) for name in absolute_names):
        for i, name in enumerate(absolute_names):
            absolute[:, i] = table.numbers((name,))[order, 0] if table.has(name) else 0.0
    legs = tuple(f"leg{i + 1}_degC" for i in range(len(robot.stiffness)))
    known = {
        "sequence", "series", "time_s", "mass_kg", "split", "temperature_degC", *legs, *absolute_names,
        *robot.configuration, REFERENCE, *coordinates.wrench, *coordinates.deflection, *coordinates.deviation,
        *coordinates.gravity, *coordinates.centre_of_mass, "marker", *POSITION, *POSITION_DEVIATION,
        *((POINT, *ALONG, *SPANS, *SPAN_DEVIATIONS) if point is not None else ()),
        *measured_names(coordinates), *(("kind",) if poses or markers else ()),
    }  # fmt: skip
    # A standard deviation whose reading is missing has no meaning, and is not to be dropped in silence.
    readings = dict(zip(coordinates.deviation, coordinates.deflection, strict=True))
    if measured and not poses and not markers:
        known -= {deviation for deviation, reading in readings.items() if not table.has(reading)}
    extra = table.frame.iloc[order][[name for name in table.columns if name not in known]]
    return LoadedPoints(
        source=table.source,
        lines=table.lines[order],
        sequence=sequence,
        series=series,
        time=time,
        configurations=configurations,
        wrenches=wrenches,
        absolute=absolute,
        payload=payload,
        gravity=gravity,
        temperature=table.numbers(("temperature_degC",))[order, 0] if table.has("temperature_degC") else None,
        leg_temperature=table.numbers(legs)[order] if any(table.has(name) for name in legs) else None,
        extra=extra.reset_index(drop=True),
        marker=marker,
        markers=markers,
        aim=read_aims(table, order) if markers else None,
        point=point,
        fixed=fixed,
        along=along,
        poses=poses,
        references=read_references(table, order),
    )


def _sensible_poses(table: Table, robot: Robot, configurations: FloatArray, order: IntArray) -> None:
    """Raise where an angle must be in degrees or a position in mm."""
    closed_form = robot.inverse_kinematics
    if closed_form is None:
        return
    split = robot.coordinates.translations
    large = np.abs(configurations[:, split:]) > LARGEST_ANGLE
    if large.any():
        row, column = (int(i) for i in np.argwhere(large)[0])
        where = table.where(int(order[row]), robot.configuration[split + column])
        what = f"{configurations[row, split + column]:g} cannot be an angle of the platform in rad"
        raise InputError(what, where=where, remedy="Check the unit.")
    farthest = np.abs(configurations[:, :split])
    row, column = divmod(int(np.argmax(farthest)), split)
    reference = closed_form.lengths(robot.reference_configuration()).max()
    stretch = float(closed_form.lengths(configurations[row]).max() / reference)
    if stretch > LARGEST_STRETCH:
        where = table.where(int(order[row]), robot.configuration[column])
        what = f"at {configurations[row, column]:g} m a leg would be {stretch:.3g} times as long as it is"
        raise InputError(what, where=where, remedy="Check the unit (m).")


def _payload(table: Table, robot: Robot, order: IntArray) -> FloatArray | None:
    columns = ("mass_kg", *robot.coordinates.centre_of_mass)
    if not table.has("mass_kg"):
        return None
    payload = table.numbers(columns)[order]
    wrong = np.flatnonzero(payload[:, 0] < 0.0)
    if wrong.size:
        where = table.where(int(order[wrong[0]]), "mass_kg")
        raise InputError("a mass cannot be negative", where=where, remedy="Correct it.")
    return payload


def _wrenches(
    table: Table,
    robot: Robot,
    configurations: FloatArray,
    payload: FloatArray | None,
    gravity: FloatArray,
    order: IntArray,
) -> FloatArray:
    coordinates = robot.coordinates
    given = None
    if payload is None or any(table.has(name) for name in coordinates.wrench):
        if payload is None and not any(table.has(name) for name in coordinates.wrench):
            remedy = f"Add {', '.join(coordinates.wrench)}, or mass_kg and the centre of mass."
            raise InputError("there is no load", where=table.where(), remedy=remedy)
        given = table.numbers(coordinates.wrench)[order]
    if payload is None:
        assert given is not None
        return given
    loaded = LoadedRobot(robot, Payload(coordinates))
    rotation = robot.jacobians(configurations).rotation
    weights = loaded.wrenches(rotation, np.concatenate([payload, gravity], axis=1))[0]
    if given is not None:
        _no_contradiction(table, robot, given, weights, order)
    return weights


def _no_contradiction(table: Table, robot: Robot, given: FloatArray, weights: FloatArray, order: IntArray) -> None:
    split = robot.coordinates.translations
    force = np.maximum(np.linalg.norm(given[:, :split], axis=1), np.linalg.norm(weights[:, :split], axis=1))
    moment = np.maximum(np.linalg.norm(given[:, split:], axis=1), np.linalg.norm(weights[:, split:], axis=1))
    allowed = np.empty_like(given)
    allowed[:, :split] = force[:, None]
    allowed[:, split:] = np.maximum(moment, LEVER * force)[:, None]
    differs = np.abs(given - weights) > CONTRADICTION * allowed + 1e-12
    if differs.any():
        row, column = np.argwhere(differs)[0]
        what = f"the wrench ({given[row, column]:g}) contradicts the payload (which makes {weights[row, column]:g})"
        remedy = "They describe the same load; correct one of them, or leave one out."
        raise InputError(what, where=table.where(int(order[row]), robot.coordinates.wrench[column]), remedy=remedy)
