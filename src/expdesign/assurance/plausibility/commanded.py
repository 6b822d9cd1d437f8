"""Measured poses beside their commands: do columns agree far better where they are swapped, or shifted by a row?

A pose differs from its command by errors of the robot, its load and its frames, which are small beside the differences
between commands. With d_i the differences less their mean, n of them, the logarithm of the ratio of likelihoods of two
readings is n/2·ln(Σd²/Σd'²), as for deflections (`recordings.py`). The differences themselves have to be smaller as
well: few rows at the levels of a factorial plan may otherwise agree by chance. A cell that is missing, or stands twice,
shifts a column from its row on.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.assurance.plausibility.evidence import GAIN, ODDS
from expdesign.assurance.plausibility.finding import Implausibility
from expdesign.assurance.plausibility.mistakes.columns import swaps
from expdesign.assurance.plausibility.mistakes.rows import SHIFTS

FEWEST = 3
"""Rows that are shifted at least."""


class _Reading(NamedTuple):
    """Columns read otherwise: the question, the first column, and differences from the commands, (n, j) each."""

    sentence: str
    column: int
    before: FloatArray
    after: FloatArray


def commanded_findings(
    commands: FloatArray,
    poses: FloatArray,
    names: Sequence[str],
    lines: IntArray,
) -> list[Implausibility]:
    """The likeliest mistake in columns of measured poses, where there is one.

    Args:
        commands: of the measured axes (m, rad), shape (N, k).
        poses: as they were measured, shape (N, k).
        names: their columns.
        lines: of the file on which the rows stand, shape (N,).
    """
    readings = [*_swapped(commands, poses, names), *_shifted(commands, poses, names, lines)]
    hurdle = np.log(ODDS * max(len(readings) * len(poses), 1))
    best: tuple[float, _Reading] | None = None
    for reading in readings:
        ratio = _squares(reading.before) / max(_squares(reading.after), 1e-300)
        likelier = 0.5 * (reading.before.size - reading.before.shape[1]) * float(np.log(max(ratio, 1e-300)))
        nearer = np.square(reading.after).sum() < 0.5 * np.square(reading.before).sum()
        if nearer and likelier > hurdle and ratio > GAIN and (best is None or likelier > best[0]):
            best = likelier, reading
    if best is None:
        return []
    found, name = best[1], names[best[1].column]
    unit = "mm" if name.endswith("_m") else "mrad"
    before, after = (1e3 * float(np.sqrt((each**2).mean())) for each in (found.before, found.after))
    what = f"measured poses are {before:.3g} {unit} (RMS) from their commands; read otherwise, {after:.3g} {unit}"
    return [Implausibility(what, found.sentence, f"column {name}", otherwise=True)]


def _squares(differences: FloatArray) -> float:
    return float(((differences - differences.mean(axis=0)) ** 2).sum())


def _swapped(commands: FloatArray, poses: FloatArray, names: Sequence[str]) -> Iterator[_Reading]:
    for text, matrix in swaps(names):
        columns = np.flatnonzero(np.diag(matrix) == 0.0)
        after = (poses @ matrix.T - commands)[:, columns]
        yield _Reading(f"{text} Exchange their names.", int(columns[0]), (poses - commands)[:, columns], after)


def _shifted(commands: FloatArray, poses: FloatArray, names: Sequence[str], lines: IntArray) -> Iterator[_Reading]:
    """Every column a row too late or too early, from the row on from which it agrees best."""
    if len(poses) <= FEWEST:
        return
    for shift, word in SHIFTS:
        rows = slice(shift, None) if shift > 0 else slice(None, shift)
        stated, moved = (poses - commands)[rows], (np.roll(poses, shift, axis=0) - commands)[rows]
        for column, name in enumerate(names):
            before, after = stated[:, column], moved[:, column]
            # Sums of the first r rows as they are, and of the others shifted, for every r.
            sums = [
                np.r_[0.0, np.cumsum(before**power)] + np.r_[0.0, np.cumsum(after[::-1] ** power)][::-1]
                for power in (1, 2)
            ]
            first = int(np.argmin((sums[1] - sums[0] ** 2 / len(before))[: len(before) + 1 - FEWEST]))
            mixed = np.where(np.arange(len(before)) < first, before, after)
            since = f" from row {lines[rows][first]} on" if first else ""
            text = f"Does the column {name} stand one row too {word}{since}? Shift it against the other columns."
            yield _Reading(text, column, before[:, None], mixed[:, None])
