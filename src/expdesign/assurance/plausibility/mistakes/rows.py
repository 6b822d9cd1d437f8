"""Rows and single numbers read otherwise: shifted against the other columns, exchanged, or slipped in one place."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.plausibility.evidence import Alternative, Evidence, Hypothesis

SLIPS = (10.0, 0.1, 100.0, 0.01, 1000.0, 0.001, -1.0)
"""By which a number is off whose decimal point slipped, or its sign."""
SHIFTS = ((-1, "late"), (1, "early"))
"""Of rows against each other, in words."""


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


def slipped_reading(evidence: Evidence) -> Iterator[Alternative]:
    """A single reading with a slipped decimal point, or of the wrong sign."""
    stated, scores = evidence.stated, evidence.reading_scores
    if scores is None:
        return
    for flat in np.argsort(scores, axis=None)[::-1][: evidence.options.candidates]:
        row, column = (int(i) for i in np.unravel_index(flat, scores.shape))
        if scores[row, column] <= evidence.options.slip:
            return
        name = evidence.names[column]
        what = f"{name} = {stated.readings[row, column]:g} in row {evidence.recordings.lines[row]}"
        for factor in SLIPS:
            sample = replace(stated, readings=divided(stated.readings, (row, column), factor))
            yield Alternative(slip_text(what, factor), sample, evidence.where(row, name), scores.size * len(SLIPS))


def slipped_load(evidence: Evidence) -> Iterator[Alternative]:
    """The load of a single row with a slipped decimal point or the wrong sign, or a load that did not act."""
    stated, scores = evidence.stated, evidence.row_scores
    if scores is None:
        return
    for row in (int(i) for i in np.argsort(scores)[::-1][: evidence.options.candidates]):
        if scores[row] <= evidence.options.slip:
            return
        line, tried = evidence.recordings.lines[row], len(scores) * (1 + len(SLIPS))
        text = f"Was row {line} recorded without its load? Write the load 0 there, or leave the row out."
        others = np.arange(len(scores))[:, None] != row
        yield Alternative(text, stated.under(np.where(others, stated.wrenches, 0.0)), evidence.where(row), tried)
        for factor in SLIPS:
            sample = stated.under(divided(stated.wrenches, row, factor))
            yield Alternative(slip_text(f"the load of row {line}", factor), sample, evidence.where(row), tried)
        for column in np.flatnonzero(stated.wrenches[row]) if evidence.recordings.payload is None else ():
            name = evidence.robot.coordinates.wrench[column]
            what = f"{name} = {stated.wrenches[row, column]:g} in row {line}"
            for factor in (-1.0, 10.0, 0.1):
                sample, of = stated.under(divided(stated.wrenches, (row, column), factor)), stated.wrenches.shape[1]
                yield Alternative(slip_text(what, factor), sample, evidence.where(row, name), tried * of)


def shifted_rows(evidence: Evidence) -> Iterator[Alternative]:
    """One group of columns stands a row too late (or too early) against the others."""
    stated, payload = evidence.stated, evidence.recordings.payload
    if len(stated.readings) < 4:
        return
    for shift, word in SHIFTS:
        deviations = None if stated.deviations is None else np.roll(stated.deviations, shift, axis=0)
        readings = replace(stated, readings=np.roll(stated.readings, shift, axis=0), deviations=deviations)
        if payload is None:
            loads = stated.under(np.roll(stated.wrenches, shift, axis=0))
        else:
            loads = evidence.with_payload(np.roll(payload, shift, axis=0))
        commands = evidence.at(np.roll(stated.configurations, shift, axis=0))
        for noun, sample in (("readings", readings), ("loads", loads), ("commands", commands)):
            text = f"Do the {noun} stand one row too {word}? Shift them against the other columns."
            yield Alternative(text, _inner(sample, shift))


def _inner(sample: Hypothesis, shift: int) -> Hypothesis:
    """Without the row that comes from the other end."""
    rows = slice(shift, None) if shift > 0 else slice(None, shift)
    deviations = None if sample.deviations is None else sample.deviations[rows]
    return Hypothesis(sample.configurations[rows], sample.wrenches[rows], sample.readings[rows], deviations)


def exchanged_rows(evidence: Evidence) -> Iterator[Alternative]:
    """The readings of two rows were exchanged."""
    stated, scores = evidence.stated, evidence.row_scores
    if scores is None:
        return
    count = len(scores)
    rows = [int(i) for i in np.argsort(scores)[::-1][: 2 * evidence.options.candidates]]
    for place, first in enumerate(rows):
        for second in rows[place + 1 :]:
            order = np.arange(count)
            order[[first, second]] = second, first
            names = sorted(int(evidence.recordings.lines[row]) for row in (first, second))
            text = f"Were the readings of rows {names[0]} and {names[1]} exchanged?"
            sample = replace(stated, readings=stated.readings[order])
            yield Alternative(text, sample, f"rows {names[0]}, {names[1]}", count * (count - 1) // 2)
