"""What the numbers themselves give away: copies, an instrument that stands still, rounding, columns without a life.

The noise against which they are judged is the smaller one of what is stated and what the fit leaves over, so that
recordings without noise, as a simulation may write them, are not taken for copies.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2 as chi_squared

from expdesign.arrays import FloatArray
from expdesign.assurance.plausibility.evidence import Evidence
from expdesign.assurance.plausibility.finding import Implausibility
from expdesign.assurance.plausibility.mistakes.mistake import Mistake

_MARKS = 15
"""Significant digits that a number holds."""


def quantum(values: FloatArray) -> float:
    """The largest power of ten, or two or five of it, of which all values are multiples; 0 where all are 0."""
    largest = float(np.abs(values).max(initial=0.0))
    if largest == 0.0:
        return 0.0
    exponent = int(np.floor(np.log10(largest)))
    for power in range(exponent, exponent - _MARKS, -1):
        for digit in (5.0, 2.0, 1.0):
            step = digit * 10.0**power
            if np.all(np.abs(values / step - np.round(values / step)) < 1e-6):
                return step
    return float(10.0 ** (exponent - _MARKS))


def noise_of(evidence: Evidence) -> FloatArray | None:
    """Standard deviation of each column's readings (k,), or None where nothing says it."""
    stated, fitted = evidence.stated.deviations, evidence.fits[0]
    found = [] if stated is None else [np.median(stated, axis=0)]
    if fitted is not None:
        found.append(np.sqrt((fitted.residuals**2).mean(axis=0)))
    return np.min(found, axis=0) if found else None


@dataclass(frozen=True)
class _Run:
    """Rows `first` to `last` agree with those `offset` rows before them."""

    first: int
    last: int
    offset: int


class CopiedRows(Mistake):
    """Rows whose readings agree with those of others far better than readings that were taken twice do.

    Readings may repeat ten times better than is stated, and a hundred times better than what the fit leaves over, in
    which there may be physics. Half the squared difference of two of them in such variances is χ² with as many degrees
    of freedom as were compared; that numbers of a certain resolution are equal has the probability step/(2√π·σ) each.
    """

    def findings(self, evidence: Evidence) -> Iterator[Implausibility]:
        noise, readings, options = noise_of(evidence), evidence.stated.readings, evidence.options
        if noise is None:
            return
        repeats = noise / (options.repeatability if evidence.noise_stated else options.repeatability**2)
        runs = agreeing_rows(readings, repeats, options.chance)
        if not runs:
            return
        longest = max(runs, key=lambda run: run.last - run.first)
        lines = evidence.recordings.lines
        rows = [f"row {lines[i]}" for i in (longest.first - longest.offset, longest.first)]
        if longest.last > longest.first:
            rows = [
                f"rows {lines[longest.first - back]} to {lines[longest.last - back]}" for back in (longest.offset, 0)
            ]
        alike = evidence.stated.wrenches[longest.first], evidence.stated.wrenches[longest.first - longest.offset]
        stuck = longest.offset == 1 and not np.array_equal(*alike)
        total = sum(run.last - run.first + 1 for run in runs)
        others = f" ({total} rows in all)" if total > longest.last - longest.first + 1 else ""
        what = f"the readings of {rows[1]} agree with those of {rows[0]} far closer than readings repeat{others}"
        likely = "Did the instrument stand still while the load changed?" if stuck else "Were rows copied?"
        yield Implausibility(what, f"{likely} Every row has to be measured; take them out.")


def agreeing_rows(readings: FloatArray, noise: FloatArray, chance: float) -> list[_Run]:
    """Runs of rows (N, k) that agree with earlier ones by less than `chance`, the noise being that of repetition (k,).

    Columns in which all rows are equal say nothing.
    """
    varies = (np.ptp(readings, axis=0) > 0.0) & (noise > 0.0)
    if len(readings) < 2 or not varies.any():
        return []
    readings, noise = readings[:, varies], noise[varies]
    count, axes = readings.shape
    step = np.array([quantum(column) for column in readings.T])
    equal = np.log(np.minimum(step / (2.0 * np.sqrt(np.pi) * noise), 1.0)).sum()
    limit, found = np.log(chance / (count * (count - 1))), list[_Run]()  # two tests of count·(count − 1)/2 pairs
    for offset in range(1, count):
        difference = np.abs(readings[offset:] - readings[:-offset])
        statistic = (np.maximum(difference, step) ** 2 / (2.0 * noise**2)).sum(axis=1)
        same = (difference == 0.0).all(axis=1)
        close = np.flatnonzero(same | (statistic < 0.1 * axes))
        for block in np.split(close, np.flatnonzero(np.diff(close) > 1) + 1) if close.size else ():
            total = float(statistic[block].sum())
            accident = min(equal * same[block].sum(), chi_squared.logcdf(total, axes * len(block)))
            if accident < limit:
                found.append(_Run(int(block[0]) + offset, int(block[-1]) + offset, offset))
    return found


class Rounded(Mistake):
    """A column rounded far more coarsely than its standard deviation says."""

    def findings(self, evidence: Evidence) -> Iterator[Implausibility]:
        deviations, readings = evidence.stated.deviations, evidence.stated.readings
        if deviations is None:
            return
        for column, name in enumerate(evidence.names):
            values = readings[:, column]
            step, stated = quantum(values), float(np.median(deviations[:, column]))
            # Finer digits would all be 0, each with a chance of 1/10 at most; a constant column is another matter.
            accident = 10.0 ** -len(values) if np.ptp(values) > 0.0 else 1.0
            rounded = step / np.sqrt(12.0)
            if rounded > 2.0 * stated and accident < evidence.options.chance:
                what = f"{name} is rounded to {step:.3g}, which alone is a standard deviation of {rounded:.2g}"
                likely = f"Stated is {stated:.2g}. Export more digits, or state at least {rounded:.2g}."
                yield Implausibility(what, likely, f"column {name}")


class Constant(Mistake):
    """A column that has one value in all rows, although the robot would move along it."""

    def findings(self, evidence: Evidence) -> Iterator[Implausibility]:
        readings, fitted = evidence.stated.readings, evidence.fits[-1]
        if len(readings) < 4 or fitted is None:
            return
        nominal = evidence.observation(evidence.stated) @ np.ones(len(evidence.robot.stiffness))
        for column, name in enumerate(evidence.names):
            values = readings[:, column]
            others = np.delete(np.arange(readings.shape[1]), column)
            if np.ptp(values) > 0.0 or not others.size:
                continue
            moved = float(np.median(np.abs(readings[:, others]) / np.maximum(np.abs(nominal[:, others]), 1e-300)))
            expected = float(np.ptp(nominal[:, column])) * min(moved, 1.0)
            deviations = evidence.stated.deviations
            stated = 0.0 if deviations is None else float(np.median(deviations[:, column]))
            share = expected / max(float(np.abs(nominal[:, evidence.linear == evidence.linear[column]]).max()), 1e-300)
            if expected > 6.0 * stated and share > 0.02:
                what = f"{name} is {values[0]:g} in every row, although the loads would change it by {expected:.2g}"
                likely = "Was it not measured? Leave the column out."
                yield Implausibility(what, likely, f"column {name}")
