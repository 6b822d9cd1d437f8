"""Single numbers that are wrong, copied or rounded, and standard deviations that contradict the readings."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtr, chdtrc

from expdesign.arrays import FloatArray
from expdesign.assurance.plausibility.evidence import Evidence
from expdesign.assurance.plausibility.finding import Implausibility
from expdesign.assurance.plausibility.mistakes.mistake import Alternative, Mistake
from expdesign.assurance.plausibility.options import MistakeOptions

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
            with np.errstate(divide="ignore"):
                nearer = float(np.log(chdtr(axes * len(block), total)))
            accident = min(equal * same[block].sum(), nearer)
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


_SLIPS = (10.0, 0.1, 100.0, 0.01, 1000.0, 0.001)
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
            for factor in (*_SLIPS, -1.0):
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
            for factor in (*_SLIPS, -1.0):
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


_MULTIPLES = (10.0, 100.0, 1000.0)
"""By which deviations come out too small where a unit is mistaken."""
_COLUMNS = 3
"""Columns whose scatter is compared at least."""


class WithoutReading(Mistake):
    """A column of standard deviations whose reading is missing."""

    def findings(self, evidence: Evidence) -> Iterator[Implausibility]:
        coordinates = evidence.robot.coordinates
        readings = evidence.recordings.components(coordinates)
        for reading, deviation in zip(readings, coordinates.deviation, strict=False):
            if deviation in evidence.recordings.extra.columns:
                what = f"{deviation} stands there without its reading {reading}"
                yield Implausibility(what, f"Add {reading} (is it spelt otherwise?), or leave {deviation} out.")


class Scatter(Mistake):
    """Columns that scatter far less than they say, or all of them more by one power of ten.

    Physics that the model lacks makes readings scatter more, never less, and not all columns by one factor.
    """

    def findings(self, evidence: Evidence) -> Iterator[Implausibility]:
        stated, fitted = evidence.stated, evidence.fits[0]
        if stated.deviations is None or fitted is None or fitted.dof <= 0:
            return
        of_readings, freedoms = (fitted.residuals / stated.deviations) ** 2, self._freedom(evidence, stated.deviations)
        squares, freedom = of_readings.sum(axis=0), freedoms.sum(axis=0)
        usable = freedom > 1.0
        scatter = np.sqrt(squares / np.maximum(freedom, 1e-12))
        accident = chdtr(np.maximum(freedom, 1e-12), squares)
        small = usable & (accident < evidence.options.chance / len(squares)) & (scatter < 0.5)
        exact = fitted.misfit < 1e-20  # a prediction without noise says nothing of an instrument
        if small.any() and not exact:
            named = [evidence.names[i] for i in np.flatnonzero(small)]
            factor = float(np.exp(-np.log(scatter[small]).mean()))
            what = f"the readings of {', '.join(named)} scatter {factor:.2g} times less than their standard deviations"
            yield Implausibility(what, "Are these too large: in another unit, or multiplied by 10? Correct them.")
        elif not small.any():
            yield from self._all_larger(of_readings, freedoms, evidence.options)

    @staticmethod
    def _freedom(evidence: Evidence, deviations: FloatArray) -> FloatArray:
        """Degrees of freedom of each reading (N, k): what the fit leaves of it."""
        observation = evidence.observation(evidence.stated) / deviations[..., None]
        rows = observation.reshape(-1, observation.shape[-1])
        scale = np.linalg.norm(rows, axis=0)
        kept = scale > 1e-6 * scale.max(initial=0.0)
        basis = np.linalg.qr(rows[:, kept] / scale[kept])[0]
        freedom: FloatArray = 1.0 - (basis**2).sum(axis=1).reshape(observation.shape[:2])
        return freedom

    @staticmethod
    def _all_larger(squares: FloatArray, freedom: FloatArray, options: MistakeOptions) -> Iterator[Implausibility]:
        """That rows and columns alike scatter more than stated by one power of ten, as they do by no physics."""
        if freedom.sum() < options.enough or freedom.shape[1] < _COLUMNS:
            return
        factor = float(np.sqrt(squares.sum() / freedom.sum()))
        alike = all(_alike(squares.sum(axis=axis), freedom.sum(axis=axis)) > options.consistent for axis in (0, 1))
        for known in _MULTIPLES:
            if alike and abs(np.log(factor / known)) < options.noisy:
                what = f"all readings scatter {factor:.3g} times more than their standard deviations"
                likely = f"Are the standard deviations {known:g} times too small: in another unit, or divided twice?"
                yield Implausibility(what, likely)


def _alike(squares: FloatArray, freedom: FloatArray) -> float:
    """p-value of Bartlett's test (1937) that sums of squares with their degrees of freedom have one variance."""
    freedom = np.maximum(freedom, 1e-9)
    pooled = squares.sum() / freedom.sum()
    statistic = freedom.sum() * np.log(pooled) - (freedom * np.log(np.maximum(squares / freedom, 1e-300))).sum()
    correction = 1.0 + ((1.0 / freedom).sum() - 1.0 / freedom.sum()) / (3.0 * (len(freedom) - 1.0))
    return float(chdtrc(len(freedom) - 1, statistic / correction))
