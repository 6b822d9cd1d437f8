"""Columns or rows in each other's place: of readings, of the command, of loads."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from expdesign.arrays import IntArray
from expdesign.assurance.plausibility.evidence import Evidence, Hypothesis
from expdesign.assurance.plausibility.mistakes.mistake import Alternative, Mistake


def _swaps(names: Sequence[str]) -> Iterator[tuple[str, IntArray]]:
    """Every pair of columns of one unit, in words, and the order of columns with the two exchanged."""
    for first, second in combinations(range(len(names)), 2):
        if names[first].rsplit("_", 1)[-1] == names[second].rsplit("_", 1)[-1]:
            order = np.arange(len(names))
            order[[first, second]] = second, first
            yield f"Are the columns {names[first]} and {names[second]} swapped?", order


class SwappedReadings(Mistake):
    """Two columns of readings of one kind."""

    def alternatives(self, evidence: Evidence) -> Iterator[Alternative]:
        stated = evidence.stated
        for text, order in _swaps(evidence.names):
            deviations = None if stated.deviations is None else stated.deviations[:, order]
            yield Alternative(text, replace(stated, readings=stated.readings[:, order], deviations=deviations))


class SwappedCommands(Mistake):
    """Two coordinates of the command, or one with the other sign."""

    def alternatives(self, evidence: Evidence) -> Iterator[Alternative]:
        commands, names = evidence.stated.configurations, evidence.robot.configuration
        varies = np.ptp(commands, axis=0) > 0.0
        for text, order in _swaps(names):
            if not np.array_equal(commands, commands[:, order]):
                yield Alternative(text, evidence.at(commands[:, order]))
        for column, name in enumerate(names):
            if varies[column]:
                factors = np.ones(len(names))
                factors[column] = -1.0
                yield Alternative(f"Has {name} the wrong sign?", evidence.at(commands * factors))


class SwappedLoads(Mistake):
    """Two coordinates of the centre of mass, of the force or of the moment."""

    def alternatives(self, evidence: Evidence) -> Iterator[Alternative]:
        stated, coordinates = evidence.stated, evidence.robot.coordinates
        payload = evidence.recordings.payload
        if payload is None:
            for text, order in _swaps(coordinates.wrench):
                yield Alternative(text, replace(stated, wrenches=stated.wrenches[:, order]))
            return
        for text, order in _swaps(coordinates.centre_of_mass):
            yield Alternative(text, evidence.with_payload(payload[:, [0, *(1 + order)]]))
        for column, name in enumerate(coordinates.centre_of_mass):
            turned = payload.copy()
            turned[:, 1 + column] *= -1.0
            yield Alternative(f"Has {name} the wrong sign?", evidence.with_payload(turned))


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
