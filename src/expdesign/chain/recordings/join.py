"""Several recordings of one robot as one."""

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pandas as pd

from expdesign.arrays import TextArray
from expdesign.chain.recordings.recordings import Recordings
from expdesign.errors import InputError


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
