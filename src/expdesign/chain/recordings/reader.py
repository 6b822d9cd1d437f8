"""Read recordings from files, of which several of one robot are one."""

import logging
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from expdesign.chain.recordings.columns import COLUMNS, REFERENCE, known_columns
from expdesign.chain.recordings.filled_in import filled_in
from expdesign.chain.recordings.joint_columns import with_joints
from expdesign.chain.recordings.measured import TURN_BLOCK, with_readings, with_targets
from expdesign.chain.recordings.points import points_of
from expdesign.chain.recordings.recordings import Recordings, in_order
from expdesign.errors import InputError
from expdesign.io.table import Table, read_table
from expdesign.mechanics.robots.robot import Robot

_LOG = logging.getLogger(__name__)
_OF_SOME = {REFERENCE, "split", *TURN_BLOCK.names, *TURN_BLOCK.deviations}
"""Columns that files which are read together need not all have."""


def read_recordings(path: Path, robot: Robot) -> Recordings:
    """Recordings of a robot.

    Raises:
        InputError: the file is missing, or anything in it is missing, not a number, or cannot be right.
    """
    return read_several([path], robot)


def read_several(paths: list[Path], robot: Robot) -> Recordings:
    """Recordings of a robot in one or more files, as if they stood in one (`joined`).

    Raises:
        InputError: a file is wrong or is given twice, or the files do not have the same columns.
    """
    for index, path in enumerate(paths):
        if path.resolve() in [other.resolve() for other in paths[:index]]:
            raise InputError("this file is given twice", where=str(path), remedy="Name it once.")
    recordings = recordings_from_tables([read_table(path, COLUMNS) for path in paths], robot)
    require_measured(recordings, robot)
    return recordings


def require_measured(recordings: Recordings, robot: Robot) -> None:
    """Raise an `InputError` where nothing deflects under load, as in a plan whose columns were filled with zeros."""
    if recordings.poses:
        return
    if robot.actuated and np.any(recordings.wrenches) and not np.any(recordings.deflections):
        what = "every deflection is 0, although there are loads"
        raise InputError(what, where=recordings.source, remedy="Fill in what was measured.")


def recordings_from_table(table: Table, robot: Robot) -> Recordings:
    """Recordings in a table; see `read_recordings`."""
    return recordings_from_tables([table], robot)


def recordings_from_tables(tables: Sequence[Table], robot: Robot) -> Recordings:
    """Recordings in several tables; see `read_several`."""
    table = joined([_in_full(table, robot) for table in tables], robot)
    points = points_of(table, robot, measured=True, recorded=True)
    return with_readings(table, points, robot.coordinates)


def _in_full(table: Table, robot: Robot) -> Table:
    """The rows of a table that were filled in, in order, with deflections and the joints' numbered names."""
    table.require(("sequence", "series"))
    table, notes = filled_in(with_targets(in_order(table), jointed=robot.jointed), robot.coordinates)
    if notes:
        _LOG.info("%s: %s", table.source, "; ".join(notes))
    return with_joints(table, robot)


def joined(tables: Sequence[Table], robot: Robot) -> Table:
    """The rows of tables of recordings in the order of their sequence.

    Sequence and series numbers that occur in more than one table are those of separate sessions, and are counted on
    with their times; numbers that do not overlap are those of one session that was written to several files.

    Raises:
        InputError: the tables do not have the same columns.
    """
    first, known = tables[0], known_columns(robot) - _OF_SOME
    if len(tables) == 1:
        return first
    for other in tables[1:]:
        apart = sorted(known & ({*first.columns} ^ {*other.columns}))
        if apart:
            what = f"{apart[0]} is in only one of {first.source} and {other.source}"
            raise InputError(what, where=other.source, remedy="Files that are read together need the same columns.")
    numbers = np.concatenate([table.integers("sequence") for table in tables])
    parts = tables if len(np.unique(numbers)) == len(numbers) else _counted_on(tables)
    whole = Table(
        source=", ".join(table.source for table in tables),
        frame=pd.concat([part.frame for part in parts], ignore_index=True).fillna(""),
        lines=np.concatenate([table.lines for table in tables]),
        written=first.written if all(table.written == first.written for table in tables) else {},
        known=first.known,
        files=np.concatenate([np.full(len(table), table.source) for table in tables]),
    )
    return in_order(whole)


def _counted_on(tables: Sequence[Table]) -> list[Table]:
    """Tables of separate sessions, the numbers and times of the later ones counted on from the earlier ones."""
    counted, last = [], {"sequence": 0, "series": 0}
    passed = 0.0
    for session, table in enumerate(tables, start=1):
        columns = {}
        for name, before in last.items():
            numbers = table.integers(name)
            columns[name] = numbers - numbers.min() + 1 + before
            last[name] = int(columns[name].max())
        texts = {name: numbers.astype(str) for name, numbers in columns.items()}
        if table.has("time_s"):
            time = table.numbers(("time_s",))[:, 0] + passed
            texts["time_s"], passed = np.array([repr(float(each)) for each in time]), float(time.max())
        if table.has(REFERENCE):
            names = table.text(REFERENCE)
            texts[REFERENCE] = np.where(names == "", "", [f"{name} of session {session}" for name in names])
        counted.append(replace(table, frame=table.frame.assign(**texts)))
    return counted
