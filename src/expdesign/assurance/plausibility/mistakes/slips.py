"""One reading or one load that was written down wrongly: a decimal point, a sign, a load that did not hang there."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from expdesign.assurance.plausibility.evidence import Evidence
from expdesign.assurance.plausibility.mistakes.mistake import Alternative, Mistake

_FACTORS = (10.0, 0.1, 100.0, 0.01, 1000.0, 0.001)
"""Of slips of the decimal point."""


def _in_words(factor: float) -> str:
    return f"{factor:g} times too large" if factor > 1.0 else f"{1.0 / factor:g} times too small"


class SlippedReading(Mistake):
    """A single reading with a slipped decimal point, or of the wrong sign."""

    def alternatives(self, evidence: Evidence) -> Iterator[Alternative]:
        stated, scores = evidence.stated, evidence.reading_scores
        if scores is None:
            return
        for flat in np.argsort(scores, axis=None)[::-1][: evidence.options.candidates]:
            row, column = (int(i) for i in np.unravel_index(flat, scores.shape))
            if scores[row, column] <= evidence.options.slip:
                return
            name, value = evidence.names[column], stated.readings[row, column]
            for factor in (*_FACTORS, -1.0):
                readings = stated.readings.copy()
                readings[row, column] /= factor
                what = "of the wrong sign" if factor < 0.0 else f"{_in_words(factor)}: did the decimal point slip"
                text = f"Is {name} = {value:g} in row {evidence.recordings.lines[row]} {what}? Correct it."
                sample = replace(stated, readings=readings)
                yield Alternative(text, sample, evidence.where(row, name), readings.size * 7)


class SlippedLoad(Mistake):
    """The load of a single row with a slipped decimal point or the wrong sign, or a load that did not act."""

    def alternatives(self, evidence: Evidence) -> Iterator[Alternative]:
        stated, scores = evidence.stated, evidence.row_scores
        if scores is None:
            return
        for row in np.argsort(scores)[::-1][: evidence.options.candidates]:
            if scores[row] <= evidence.options.slip:
                return
            line, tried = evidence.recordings.lines[row], len(scores) * 8
            wrenches = stated.wrenches.copy()
            wrenches[row] = 0.0
            text = f"Was row {line} recorded without its load? Write the load 0 there, or leave the row out."
            yield Alternative(text, replace(stated, wrenches=wrenches), evidence.where(int(row)), tried)
            for factor in (*_FACTORS, -1.0):
                what = "of the wrong sign" if factor < 0.0 else f"{_in_words(factor)}: did the decimal point slip"
                wrenches = stated.wrenches.copy()
                wrenches[row] /= factor
                text = f"Is the load of row {line} {what}? Correct it."
                yield Alternative(text, replace(stated, wrenches=wrenches), evidence.where(int(row)), tried)
            if evidence.recordings.payload is None:
                yield from self._components(evidence, int(row), tried * wrenches.shape[1])

    @staticmethod
    def _components(evidence: Evidence, row: int, tried: int) -> Iterator[Alternative]:
        """One force or moment of a row."""
        stated, line = evidence.stated, evidence.recordings.lines[row]
        for column in np.flatnonzero(stated.wrenches[row]):
            name = evidence.robot.coordinates.wrench[column]
            for factor in (-1.0, 10.0, 0.1):
                wrenches = stated.wrenches.copy()
                wrenches[row, column] /= factor
                what = "of the wrong sign" if factor < 0.0 else f"{_in_words(factor)}: did the decimal point slip"
                text = f"Is {name} = {stated.wrenches[row, column]:g} in row {line} {what}? Correct it."
                yield Alternative(text, replace(stated, wrenches=wrenches), evidence.where(row, name), tried)
