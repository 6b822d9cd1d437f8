"""Read recordings and points from files, and several recordings of one robot as one."""

import logging
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from expdesign.arrays import TextArray
from expdesign.chain.recordings.columns import COLUMNS
from expdesign.chain.recordings.filled_in import filled_in
from expdesign.chain.recordings.joint_columns import with_joints
from expdesign.chain.recordings.measured import with_readings, with_targets
from expdesign.chain.recordings.points import points_of
from expdesign.chain.recordings.recordings import Recordings, in_order
from expdesign.errors import InputError
from expdesign.io.table import Table, read_table
from expdesign.mechanics.robots.robot import Robot

_LOG = logging.getLogger(__name__)


def read_recordings(path: Path, robot: Robot) -> Recordings:
    """Recordings of a robot.

    Raises:
        InputError: the file is missing, or anything in it is missing, not a number, or cannot be right.
    """
    recordings = recordings_from_table(read_table(path, COLUMNS), robot)
    require_measured(recordings, robot)
    return recordings


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
    table, notes = filled_in(with_targets(in_order(table), jointed=robot.jointed), robot.coordinates)
    if notes:
        _LOG.info("%s: %s", table.source, "; ".join(notes))
    table = with_joints(table, robot)
    points = points_of(table, robot, measured=True, recorded=True)
    return with_readings(table, points, robot.coordinates)


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
        if item.name in (
            "source",
            "extra",
            "files",
            "file",
            "markers",
            "sites",
            "stations",
            "references",
            "fixed",
            "written",
        ):
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
    seen = {name: place for part in counted for name, *place in part.seen}
    together = Recordings(
        **merged,
        markers=names,
        sites=tuple(seen[name][0] for name in names) if any(part.sites for part in parts) else (),
        stations=tuple(seen[name][1] for name in names) if any(part.stations for part in parts) else (),
        references=_references(counted),
        source=", ".join(part.source for part in parts),
        extra=pd.concat([part.extra for part in parts], ignore_index=True),
        written=first.written if all(part.written == first.written for part in parts) else {},
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
    aim, angles = np.tile(np.eye(3), (len(part), 1, 1)), np.zeros((len(part), 3))
    readings = np.hstack([part.deflections, none])
    return replace(part, aim=aim, angles=angles, axes=np.arange(6), deflections=readings, deviations=deviations)


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
