"""Several recordings of one robot as one."""

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pandas as pd

from expdesign.errors import InputError
from expdesign.recordings.recordings import Recordings


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
    merged: dict[str, Any] = {}
    for item in fields(Recordings):
        values = [getattr(part, item.name) for part in counted]
        if item.name in ("source", "extra", "files", "file", "markers"):
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
        source=", ".join(part.source for part in parts),
        extra=pd.concat([part.extra for part in parts], ignore_index=True),
        files=tuple(part.source for part in parts),
        file=np.repeat(np.arange(len(parts)), [len(part) for part in parts]),
    )
    return together.rows(np.argsort(together.sequence, kind="stable"))


def _count_on(parts: list[Recordings]) -> list[Recordings]:
    counted: list[Recordings] = []
    sequence, series, time = 0, 0, 0.0
    for part in parts:
        shifted = replace(
            part,
            sequence=part.sequence - part.sequence.min() + 1 + sequence,
            series=part.series - part.series.min() + 1 + series,
            time=None if part.time is None else part.time + time,
        )
        sequence, series = int(shifted.sequence.max()), int(shifted.series.max())
        time = 0.0 if shifted.time is None else float(shifted.time.max())
        counted.append(shifted)
    return counted
