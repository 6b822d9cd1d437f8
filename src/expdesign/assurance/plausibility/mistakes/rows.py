"""Rows and single numbers read otherwise: shifted against the other columns, exchanged, or slipped in one place."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.plausibility.evidence import Alternative, Evidence
from expdesign.chain.recordings.recordings import Recordings

SLIPS = (10.0, 0.1, 100.0, 0.01, 1000.0, 0.001, -1.0)
"""By which a number is off whose decimal point slipped, or its sign."""
SHIFTS = ((-1, "late"), (1, "early"))
"""Of rows against each other, in words."""
_BEYOND, _CANDIDATES = 3.0, 4
"""Standard deviations from what the others say beyond which slips are tried for a row or a reading, and of these so
many, the most conspicuous ones.
"""


def slip_text(what: str, factor: float) -> str:
    """The question whether a number has slipped."""
    if factor < 0.0:
        return f"Is {what} of the wrong sign? Correct it."
    size = f"{factor:g} times too large" if factor > 1.0 else f"{1.0 / factor:g} times too small"
    return f"Is {what} {size}: did the decimal point slip? Correct it."


def divided(values: FloatArray, place: Any, factor: float) -> FloatArray:
    """Values with one of them, or one row of them, divided by a factor."""
    changed = values.copy()
    changed[place] /= factor
    return changed


def slipped(
    recordings: Recordings, row: int, column: int, name: str, where: str = "", tried: int = 1
) -> Iterator[Alternative]:
    """A single reading with a slipped decimal point, or of the wrong sign."""
    what = f"{name} = {recordings.deflections[row, column]:g} in row {recordings.lines[row]}"
    for factor in SLIPS:
        sample = replace(recordings, deflections=divided(recordings.deflections, (row, column), factor))
        yield Alternative(slip_text(what, factor), sample, where, tried)


def shifted(recordings: Recordings, shift: int, *names: str) -> Recordings:
    """Some columns shifted against the others, without the row that comes from the other end."""
    stated = {name: getattr(recordings, name) for name in names}
    rolled = {name: np.roll(values, shift, axis=0) for name, values in stated.items() if values is not None}
    inner = slice(shift, None) if shift > 0 else slice(None, shift)
    return replace(recordings, **rolled).rows(np.arange(len(recordings))[inner])


def slipped_reading(evidence: Evidence) -> Iterator[Alternative]:
    """A single reading with a slipped decimal point, or of the wrong sign."""
    scores = evidence.reading_scores
    for flat in np.argsort(scores, axis=None)[::-1][:_CANDIDATES]:
        row, column = (int(i) for i in np.unravel_index(flat, scores.shape))
        if scores[row, column] > _BEYOND:
            name = evidence.names[column]
            where, tried = evidence.where(row, name), scores.size * len(SLIPS)
            yield from slipped(evidence.recordings, row, column, name, where, tried)


def slipped_load(evidence: Evidence) -> Iterator[Alternative]:
    """The load of a single row with a slipped decimal point or the wrong sign, or a load that did not act."""
    stated, scores = evidence.recordings, evidence.row_scores
    for row in (int(i) for i in np.argsort(scores)[::-1][:_CANDIDATES]):
        if scores[row] <= _BEYOND:
            return
        line, where, tried = stated.lines[row], evidence.where(row), len(scores) * (1 + len(SLIPS))
        text = f"Was row {line} recorded without its load? Write the load 0 there, or leave the row out."
        yield Alternative(text, _loaded(stated, row, float("inf")), where, tried)
        for factor in SLIPS:
            yield Alternative(slip_text(f"the load of row {line}", factor), _loaded(stated, row, factor), where, tried)
        for column in np.flatnonzero(stated.wrenches[row]) if stated.payload is None else ():
            name = evidence.robot.coordinates.wrench[column]
            what, of = f"{name} = {stated.wrenches[row, column]:g} in row {line}", tried * stated.wrenches.shape[1]
            for factor in (-1.0, 10.0, 0.1):
                sample = _loaded(stated, (row, column), factor)
                yield Alternative(slip_text(what, factor), sample, evidence.where(row, name), of)


def _loaded(stated: Recordings, place: Any, factor: float) -> Recordings:
    """The load of a row, or one number of it, divided by a factor."""
    return replace(stated, wrenches=divided(stated.wrenches, place, factor))


def shifted_rows(evidence: Evidence) -> Iterator[Alternative]:
    """One group of columns stands a row too late (or too early) against the others."""
    stated, loads = evidence.recordings, "wrenches" if evidence.recordings.payload is None else "payload"
    groups = {"readings": ("deflections", "deviations"), "loads": (loads,), "commands": ("configurations",)}
    for shift, word in SHIFTS if len(stated) >= 4 else ():
        for noun, names in groups.items():
            text = f"Do the {noun} stand one row too {word}? Shift them against the other columns."
            sample = shifted(stated, shift, *names)
            yield Alternative(text, sample if noun == "readings" else evidence.hung(sample))


def exchanged_rows(evidence: Evidence) -> Iterator[Alternative]:
    """The readings of two rows were exchanged."""
    stated = evidence.recordings
    worst = [int(i) for i in np.argsort(evidence.row_scores)[::-1][: 2 * _CANDIDATES]]
    count = len(stated)
    for pair in combinations(worst, 2):
        order = np.arange(count)
        order[list(pair)] = pair[::-1]
        first, second = sorted(int(stated.lines[row]) for row in pair)
        sample = replace(stated, deflections=stated.deflections[order])
        text = f"Were the readings of rows {first} and {second} exchanged?"
        yield Alternative(text, sample, f"rows {first}, {second}", count * (count - 1) // 2)
