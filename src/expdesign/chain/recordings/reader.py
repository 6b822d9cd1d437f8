"""Read recordings and points from tables; faults name file, row and column (file-formats.md, Recordings).

What was measured, read by the kind of quantity that the columns of a table hold.

Several recordings of one robot as one.
"""

import logging
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from expdesign.arrays import BoolArray, FloatArray, IntArray, TextArray
from expdesign.chain.recordings.columns import (
    known_columns,
    leg_temperatures,
    order_in_time,
    read_deflections,
    read_deviations,
    read_markers,
    read_payload,
    read_position_deviations,
    read_positions,
    read_sequence,
    read_test_rows,
    read_time,
    require_one_command,
    whole_load,
)
from expdesign.chain.recordings.filled_in import filled_in
from expdesign.chain.recordings.joint_columns import require_its_own, with_joint_columns
from expdesign.chain.recordings.pose_columns import (
    measures_poses,
    read_aims,
    read_measured,
    read_turn_deviations,
    turned,
    with_targets,
)
from expdesign.chain.recordings.recordings import DEFLECTIONS, POSES, POSITIONS, LoadedPoints, Measurand, Recordings
from expdesign.chain.recordings.references import read_references, require_one_command_per_reference
from expdesign.chain.recordings.spans import (
    ALONG,
    POINT,
    SPAN_DEVIATIONS,
    SPANS,
    read_fixed,
    read_span_deviations,
    read_spans,
)
from expdesign.coordinates import Coordinates
from expdesign.errors import InputError
from expdesign.io.table import Table, read_table
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.loads.load import Payload
from expdesign.mechanics.robots.robot import Robot

Measured = tuple[IntArray, FloatArray, FloatArray | None]
"""Indices of the measured components (k,), readings (N, k) and their standard deviations (N, k), where stated."""


def _deflections(table: Table, points: LoadedPoints, coordinates: Coordinates, order: IntArray) -> Measured:
    axes, readings = read_deflections(table, coordinates, order)
    return axes, readings, read_deviations(table, coordinates, axes, order)


def _poses(table: Table, points: LoadedPoints, coordinates: Coordinates, order: IntArray) -> Measured:
    axes, readings = read_measured(table, points, coordinates, order)
    return axes, readings, read_deviations(table, coordinates, axes, order)


def _positions(table: Table, points: LoadedPoints, coordinates: Coordinates, order: IntArray) -> Measured:
    axes, readings, deviations = _marked(table, points, coordinates, order)
    if points.point is None:
        return axes, readings, deviations
    spans, stated = read_spans(table, order), read_span_deviations(table, order)
    readings, axes = np.hstack([readings, spans]), np.concatenate([axes, [6, 7]])
    seen: BoolArray = np.logical_or.reduce(np.isfinite(readings), axis=0)
    if (stated is None) != (deviations is None) and seen[:-2].any():
        what = "standard deviations of positions or of distances are missing where the others are stated"
        raise InputError(what, where=table.where(), remedy="State both, or none to have them estimated.")
    if stated is None:
        return axes[seen], readings[:, seen], None
    none = np.full((len(readings), len(axes) - 2), np.nan)
    both = np.hstack([none if deviations is None else deviations, stated])
    return axes[seen], readings[:, seen], both[:, seen]


def _marked(table: Table, points: LoadedPoints, coordinates: Coordinates, order: IntArray) -> Measured:
    positions, deviations = read_positions(table, coordinates, order), read_position_deviations(table, order)
    if points.aim is None:
        return np.arange(3), positions, deviations
    rotations = turned(table, order)
    stated = read_turn_deviations(table, coordinates, rotations, order)
    if (stated is None) != (deviations is None):
        what = "standard deviations of positions or of orientations are missing where the others are stated"
        raise InputError(what, where=table.where(), remedy="State both, or none to have them estimated.")
    both = None if stated is None or deviations is None else np.hstack([deviations, stated])
    return np.arange(6), np.hstack([positions, rotations]), both


READERS: dict[Measurand, Callable[[Table, LoadedPoints, Coordinates, IntArray], Measured]] = {
    DEFLECTIONS: _deflections,
    POSES: _poses,
    POSITIONS: _positions,
}


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
    if robot.actuated and np.any(recordings.wrenches) and not np.any(recordings.deflections):
        what = "every deflection is 0, although there are loads"
        raise InputError(what, where=recordings.source, remedy="Fill in what was measured.")


def recordings_from_table(table: Table, robot: Robot) -> Recordings:
    """Recordings in a table; see `read_recordings`."""
    table.require(("sequence", "series"))
    table, notes = filled_in(with_targets(table, robot), robot.coordinates)
    if notes:
        _LOG.info("%s: %s", table.source, "; ".join(notes))
    points = _points(table, robot, measured=True)
    if robot.actuated:
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
    point, fixed, along = read_fixed(table, order) if markers and robot.jointed else (None, (), None)
    if measured and robot.actuated and not markers and not poses:
        # A body has no actuators: its pose says where it is, and is not a command that a series shares.
        require_one_command(table, robot.configuration, configurations, series, order)
    gravity = np.broadcast_to(robot.gravity, (len(table), len(robot.gravity))).copy()
    for i, name in enumerate(coordinates.gravity):
        if table.has(name):
            gravity[:, i] = table.numbers((name,))[order, 0]
    payload = read_payload(table, coordinates)[order] if table.has("mass_kg") else None
    unloaded = payload is None and not any(table.has(name) for name in coordinates.wrench)
    # Deflections need a load; absolute readings show the weight of what is there.
    unloaded &= poses or bool(markers) or (robot.jointed and not measured)
    load = (table, robot, configurations, payload, gravity, order)
    wrenches = np.zeros((len(table), coordinates.n)) if unloaded else _wrenches(*load)
    absolute = wrenches.copy()
    absolute_names = whole_load(coordinates)
    if any(table.has(name) for name in absolute_names):
        for i, name in enumerate(absolute_names):
            absolute[:, i] = table.numbers((name,))[order, 0] if table.has(name) else 0.0
    legs = leg_temperatures(robot)
    known = known_columns(robot) | ({"kind"} if poses or markers else set())
    known |= {POINT, *ALONG, *SPANS, *SPAN_DEVIATIONS} if point is not None else set()
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
    if not robot.on_legs:
        return
    split = robot.coordinates.translations
    angles, what = configurations[:, split:], "{:g} cannot be an angle of the platform in rad"
    large = np.abs(angles) > LARGEST_ANGLE
    table.refuse(large, robot.configuration[split:], what, "Check the unit.", order, angles)
    farthest = np.abs(configurations[:, :split])
    row, column = divmod(int(np.argmax(farthest)), split)
    closed_form = robot.inverse_kinematics
    reference = closed_form.lengths(robot.reference_configuration()).max()
    stretch = float(closed_form.lengths(configurations[row]).max() / reference)
    if stretch > LARGEST_STRETCH:
        where = table.where(int(order[row]), robot.configuration[column])
        what = f"at {configurations[row, column]:g} m a leg would be {stretch:.3g} times as long as it is"
        raise InputError(what, where=where, remedy="Check the unit (m).")


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


def join(parts: list[Recordings]) -> Recordings:
    """All rows in the order of their sequence.

    Where sequence numbers overlap the parts are separate sessions: numbers and times of the later ones are counted on
    from the earlier ones. Otherwise they are one session in several files, and nothing is renumbered.

    Raises:
        InputError: the parts do not have the same columns.
    """
    if len(parts) == 1:
        return parts[0]
    first = parts[0]
    numbers = np.concatenate([part.sequence for part in parts])
    counted = list(parts) if len(np.unique(numbers)) == len(numbers) else _count_on(parts)
    if any(part.point is not None for part in counted):
        remedy = "Put them into one file with the other readings."
        raise InputError("distances and gauges are read from one file", where=parts[-1].source, remedy=remedy)
    if any(part.aim is not None for part in counted):
        counted = [_with_orientations(part) for part in counted]
        first = counted[0]
    merged: dict[str, Any] = {}
    for item in fields(Recordings):
        values = [getattr(part, item.name) for part in counted]
        if item.name in ("source", "extra", "files", "file", "markers", "references", "fixed"):
            continue
        if any((value is None) != (values[0] is None) for value in values):
            other = next(p for p, value in zip(counted, values, strict=True) if (value is None) != (values[0] is None))
            what = f"{item.name} is known in only one of {first.source} and {other.source}"
            raise InputError(what, where=other.source, remedy="Files that are read together need the same columns.")
        if item.name == "poses":
            merged["poses"] = first.poses
        elif item.name == "axes":
            for part in counted:
                if part.measurand != first.measurand or not np.array_equal(part.axes, first.axes):
                    what = f"the measured columns are not those of {first.source}"
                    raise InputError(what, where=part.source, remedy="Identify the files one by one.")
            merged["axes"] = first.axes
        else:
            merged[item.name] = None if values[0] is None else np.concatenate(values)
    names = tuple(dict.fromkeys(name for part in counted for name in part.markers))
    if names:
        # Every file numbers the markers that it has; together they are numbered anew.
        renumbered = [np.array([names.index(name) for name in part.markers])[part.marker] for part in counted]
        merged["marker"] = np.concatenate(renumbered)
    together = Recordings(
        **merged,
        markers=names,
        references=_references(counted),
        source=", ".join(part.source for part in parts),
        extra=pd.concat([part.extra for part in parts], ignore_index=True),
        files=tuple(part.source for part in parts),
        file=np.repeat(np.arange(len(parts)), [len(part) for part in parts]),
    )
    return together.rows(np.argsort(together.sequence, kind="stable"))


def _references(parts: list[Recordings]) -> TextArray | None:
    """References of all rows; empty where a file says nothing of them."""
    if all(part.references is None for part in parts):
        return None
    stated = [np.full(len(part), "") if part.references is None else part.references for part in parts]
    return np.concatenate(stated)


def _with_orientations(part: Recordings) -> Recordings:
    """Positions of markers with orientations that were not read, beside others that were."""
    if part.aim is not None or part.marker is None:
        return part
    none = np.full((len(part), 3), np.nan)
    deviations = None if part.deviations is None else np.hstack([part.deviations, none])
    aim = np.tile(np.eye(3), (len(part), 1, 1))
    readings = np.hstack([part.deflections, none])
    return replace(part, aim=aim, axes=np.arange(6), deflections=readings, deviations=deviations)


def _count_on(parts: list[Recordings]) -> list[Recordings]:
    counted: list[Recordings] = []
    sequence, series, time = 0, 0, 0.0
    for part in parts:
        shifted = replace(
            part,
            sequence=part.sequence - part.sequence.min() + 1 + sequence,
            series=part.series - part.series.min() + 1 + series,
            time=None if part.time is None else part.time + time,
            references=None if part.references is None else _of_session(part.references, len(counted) + 1),
        )
        sequence, series = int(shifted.sequence.max()), int(shifted.series.max())
        time = 0.0 if shifted.time is None else float(shifted.time.max())
        counted.append(shifted)
    return counted


def _of_session(references: TextArray, number: int) -> TextArray:
    """Names of one session, which are not those of another."""
    return np.array([name and f"{name} of session {number}" for name in references.tolist()], dtype=str)
