"""Rows in each other's place: readings, loads or commands that stand a row too late or too early."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from expdesign.assurance.plausibility.evidence import Evidence, Hypothesis
from expdesign.assurance.plausibility.mistakes.mistake import Alternative, Mistake


class ShiftedRows(Mistake):
    """One group of columns stands a row too late (or too early) against the others."""

    def alternatives(self, evidence: Evidence) -> Iterator[Alternative]:
        stated, payload = evidence.stated, evidence.recordings.payload
        if len(stated.readings) < 4:
            return
        for shift, word in ((-1, "late"), (1, "early")):
            deviations = None if stated.deviations is None else np.roll(stated.deviations, shift, axis=0)
            readings = replace(stated, readings=np.roll(stated.readings, shift, axis=0), deviations=deviations)
            if payload is None:
                loads = replace(stated, wrenches=np.roll(stated.wrenches, shift, axis=0))
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


class ExchangedRows(Mistake):
    """The readings of two rows were exchanged."""

    def alternatives(self, evidence: Evidence) -> Iterator[Alternative]:
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
