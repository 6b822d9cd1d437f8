"""What gives a mistake away by itself: copied, rounded or constant readings, their scatter, and an odd stiffness."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtr, chdtrc

from expdesign.arrays import BoolArray, FloatArray
from expdesign.assurance.plausibility.evidence import (
    CHANCE,
    CONSISTENT,
    FAIR,
    MOST,
    REFUTED,
    REPEATABILITY,
    SENSELESS,
    Evidence,
    Fitted,
)
from expdesign.assurance.plausibility.finding import Implausibility
from expdesign.chain.recordings.recordings import Recordings

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
    stated, fitted = evidence.recordings.deviations, evidence.fits[0]
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


def copied_rows(evidence: Evidence) -> Iterator[Implausibility]:
    """Rows whose readings agree with those of others far better than readings that were taken twice do.

    Readings may repeat ten times better than is stated, and a hundred times better than what the fit leaves over, in
    which there may be physics. Half the squared difference of two of them in such variances is χ² with as many degrees
    of freedom as were compared; that numbers of a certain resolution are equal has the probability step/(2√π·σ) each.
    """
    noise, stated = noise_of(evidence), evidence.recordings
    if noise is not None:
        repeats = noise / (REPEATABILITY if evidence.noise_stated else REPEATABILITY**2)
        yield from copies(stated, repeats, np.abs(np.diff(stated.wrenches, axis=0)).sum(axis=1) > 0.0)


def copies(recordings: Recordings, noise: FloatArray, changed: BoolArray | None = None) -> list[Implausibility]:
    """The longest run of rows that agree with earlier ones, the noise being that of repetition (k,).

    `changed` says between which rows the load does, shape (N − 1,), so that an instrument should have moved.
    """
    runs = agreeing_rows(recordings.deflections, noise, CHANCE)
    if not runs:
        return []
    longest, lines = max(runs, key=lambda run: run.last - run.first), recordings.lines
    rows = [f"row {lines[i]}" for i in (longest.first - longest.offset, longest.first)]
    if longest.last > longest.first:
        rows = [f"rows {lines[longest.first - back]} to {lines[longest.last - back]}" for back in (longest.offset, 0)]
    total = sum(run.last - run.first + 1 for run in runs)
    others = f" ({total} rows in all)" if total > longest.last - longest.first + 1 else ""
    what = f"the readings of {rows[1]} agree with those of {rows[0]} far closer than readings repeat{others}"
    stuck = longest.offset == 1 and changed is not None and changed[longest.first - 1]
    likely = "Did the instrument stand still while the load changed?" if stuck else "Were rows copied?"
    return [Implausibility(what, f"{likely} Every row has to be measured; take them out.")]


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


def rounded(evidence: Evidence) -> Iterator[Implausibility]:
    """A column rounded far more coarsely than its standard deviation says."""
    deviations, readings = evidence.recordings.deviations, evidence.recordings.deflections
    if deviations is None:
        return
    for column, name in enumerate(evidence.names):
        values = readings[:, column]
        step, stated = quantum(values), float(np.median(deviations[:, column]))
        # Finer digits would all be 0, each with a chance of 1/10 at most; a constant column is another matter.
        accident = 10.0 ** -len(values) if np.ptp(values) > 0.0 else 1.0
        alone = step / np.sqrt(12.0)
        if alone > 2.0 * stated and accident < CHANCE:
            what = f"{name} is rounded to {step:.3g}, which alone is a standard deviation of {alone:.2g}"
            likely = f"Stated is {stated:.2g}. Export more digits, or state at least {alone:.2g}."
            yield Implausibility(what, likely, f"column {name}")


def constant(evidence: Evidence) -> Iterator[Implausibility]:
    """A column that has one value in all rows, although the robot would move along it."""
    readings, fitted = evidence.recordings.deflections, evidence.fits[-1]
    if len(readings) < 4 or fitted is None:
        return
    nominal = evidence.observation(evidence.recordings) @ np.ones(len(evidence.robot.stiffness))
    for column, name in enumerate(evidence.names):
        values = readings[:, column]
        others = np.delete(np.arange(readings.shape[1]), column)
        if np.ptp(values) > 0.0 or not others.size:
            continue
        moved = float(np.median(np.abs(readings[:, others]) / np.maximum(np.abs(nominal[:, others]), 1e-300)))
        expected = float(np.ptp(nominal[:, column])) * min(moved, 1.0)
        deviations = evidence.recordings.deviations
        stated = 0.0 if deviations is None else float(np.median(deviations[:, column]))
        share = expected / max(float(np.abs(nominal[:, evidence.linear == evidence.linear[column]]).max()), 1e-300)
        if expected > 6.0 * stated and share > 0.02:
            what = f"{name} is {values[0]:g} in every row, although the loads would change it by {expected:.2g}"
            likely = "Was it not measured? Leave the column out."
            yield Implausibility(what, likely, f"column {name}")


def without_reading(evidence: Evidence) -> Iterator[Implausibility]:
    """A column of standard deviations whose reading is missing."""
    coordinates = evidence.robot.coordinates
    readings = evidence.recordings.components(coordinates)
    for reading, deviation in zip(readings, coordinates.deviation, strict=False):
        if deviation in evidence.recordings.extra.columns:
            what = f"{deviation} stands there without its reading {reading}"
            yield Implausibility(what, f"Add {reading} (is it spelt otherwise?), or leave {deviation} out.")


_ENOUGH, _COLUMNS = 40.0, 3
"""Degrees of freedom, and columns, from which on the scatter of rows and columns is compared."""
_NOISY = 0.2
"""Logarithm of what all readings scatter by beside the power of ten of a mistaken unit."""
_THOUSAND, _NEAR = 1e3, np.sqrt(10.0)


def scatter(evidence: Evidence) -> Iterator[Implausibility]:
    """Columns that scatter far less than they say, or all more by one power of ten, or one kind a thousand times more.

    Physics that the model lacks makes readings scatter more, never less, not all columns by one factor, and it moves a
    platform and turns it.
    """
    fitted, names = evidence.fits[0], np.array(evidence.names)
    if not evidence.noise_stated or fitted is None or fitted.dof <= 0:
        return
    of_readings, shape = fitted.model.projected**2, fitted.weights.shape
    leverage = ((fitted.model.columns @ fitted.model.root) ** 2).sum(axis=1)
    parts = of_readings.reshape(shape), (1.0 - leverage).reshape(shape)
    squares, freedom = (part.sum(axis=0) for part in parts)
    times = np.sqrt(squares / np.maximum(freedom, 1e-12))
    accident = chdtr(np.maximum(freedom, 1e-12), squares)
    small = (freedom > 1.0) & (accident < CHANCE / len(squares)) & (times < 0.5)
    if small.any():
        if fitted.misfit >= 1e-20:  # a prediction without noise says nothing of an instrument
            factor = float(np.exp(-np.log(times[small]).mean()))
            what = f"the readings of {', '.join(names[small])} scatter {factor:.2g} times less than their standard"
            likely = "Are these too large: in another unit, or multiplied by 10? Correct them."
            yield Implausibility(f"{what} deviations", likely)
        return
    factor = float(np.sqrt(squares.sum() / freedom.sum()))
    known = next((known for known in (10.0, 100.0, 1000.0) if abs(np.log(factor / known)) < _NOISY), None)
    enough = freedom.sum() >= _ENOUGH and len(squares) >= _COLUMNS
    if known and enough and all(_alike(*(part.sum(axis=axis) for part in parts)) > CONSISTENT for axis in (0, 1)):
        what = f"all readings scatter {factor:.3g} times more than their standard deviations"
        likely = f"Are the standard deviations {known:g} times too small: in another unit, or divided twice?"
        yield Implausibility(what, likely)
    by_size, linear = evidence.fits[-1], evidence.linear
    if by_size is None or by_size.misfit > FAIR or linear.all() or not linear.any():
        return
    size = [float(np.exp(np.log(np.maximum(times[kind], 1e-300)).mean())) for kind in (linear, ~linear)]
    large = int(np.argmax(size))
    if abs(np.log(size[large] / _THOUSAND)) < np.log(_NEAR) and size[1 - large] < _THOUSAND / _NEAR**3:
        what = f"the readings of {', '.join(names[linear == (large == 0)])} scatter {size[large]:.3g} times more than "
        what += f"their standard deviations, the others {size[1 - large]:.2g} times"
        unit = "mm, or µm divided once too often" if large == 0 else "mrad, or µrad divided once too often"
        likely = f"Are these standard deviations a thousand times too small (numbers in {unit})? Correct them."
        yield Implausibility(what, likely)


def _alike(squares: FloatArray, freedom: FloatArray) -> float:
    """p-value of Bartlett's test (1937) that sums of squares with their degrees of freedom have one variance."""
    freedom = np.maximum(freedom, 1e-9)
    pooled = squares.sum() / freedom.sum()
    statistic = freedom.sum() * np.log(pooled) - (freedom * np.log(np.maximum(squares / freedom, 1e-300))).sum()
    correction = 1.0 + ((1.0 / freedom).sum() - 1.0 / freedom.sum()) / (3.0 * (len(freedom) - 1.0))
    return float(chdtrc(len(freedom) - 1, statistic / correction))


_UNIT_RATIO, _OTHER = 30.0, 2.0
"""Factors between identified and stated stiffness beyond which a unit is suspected, and another robot."""
_ONE_FACTOR, _NEAR_ONE, _EXACT = 0.35, 0.15, 0.04
"""Standard deviation of the logarithms of the actuators' factors below which they are one; distance of its logarithm
from a known one within which it is that one; and both for factors that robots may have as well.
"""
_LITTLE = 0.02
"""Share of the readings (squares) that is left over from which on little fits."""
_KGF, _POUND = 9.80665, 0.45359237
"""N of a kgf, kg of a pound."""
_TEN_SOFT, _HUNDRED = (
    "are the readings ten times too large",
    "or readings, a hundred times off: cm, or a decimal point?",
)
_FACTORS = (
    (_KGF, f"Are weights in mass_kg ten times too small, or {_TEN_SOFT}?",
     f"Are the forces in kgf, as if kg stood in the columns of N (1 kgf = 9.80665 N), or {_TEN_SOFT}?", False),
    (1.0 / _KGF, "Are weights in N in the column mass_kg (1 kg weighs 9.80665 N), or the readings ten times too small?",
     "Are the forces ten times too large (N, not kgf), or the readings ten times too small?", False),
    (_POUND, "Are masses in lb in the column mass_kg (1 lb = 0.4536 kg)?", "", True),
    (100.0, f"Are masses, {_HUNDRED}", f"Are forces, {_HUNDRED}", False),
    (0.01, f"Are masses, {_HUNDRED}", f"Are forces, {_HUNDRED}", False),
)  # fmt: skip
"""Identified by stated compliance, the question for recordings with masses, that for recordings with forces, and
whether robots have such factors as well, so that all actuators must have it to a few per cent."""


def stiffness_factor(evidence: Evidence) -> Iterator[Implausibility]:
    """Everything fits, with another stiffness than the file states; or little does, and all actuators come out alike.

    What a robot lacks in physics leaves its stiffness near what it is; the geometry of another one does not.
    """
    stated, fitted = evidence.fits[0], evidence.fits[-1]
    if stated is None or fitted is None or fitted.misfit >= SENSELESS:
        return
    known, ratio, common = _known_factor(fitted, evidence), fitted.ratio, fitted.alike
    if fitted.share_positive >= MOST and (known is not None or not 1.0 / _UNIT_RATIO < ratio < _UNIT_RATIO):
        all_alike = "" if known is None else ", all actuators alike"
        units = (
            "Are deflections in mm (and mrad), a mass in tonnes, a force in kN, or `actuator_stiffness` in another "
            "unit?"
            if ratio > 1.0
            else "Is a mass in grams or a force in mN, are deflections in m in columns that are named for mm, or is "
            "`actuator_stiffness` in N/µm or N/mm?"
        )
        yield Implausibility(f"the robot comes out {_times(ratio)} than its file says{all_alike}", known or units)
    refuted = evidence.noise_stated and stated.p_value < REFUTED and fitted.misfit > _LITTLE
    if refuted and known is None and common is not None and common[1] < _ONE_FACTOR and abs(common[0]) > np.log(_OTHER):
        what = f"all actuators come out {_times(float(np.exp(common[0])))} than the robot file says, and "
        what += f"{100 * fitted.misfit:.2g} % of the readings are left over"
        likely = "Is this the file of another robot? Compare the robot file with the robot that was measured."
        yield Implausibility(what, likely)


def _times(factor: float) -> str:
    return f"{max(factor, 1.0 / factor):.3g} times {'softer' if factor > 1.0 else 'stiffer'}"


def _known_factor(fitted: Fitted, evidence: Evidence) -> str | None:
    """The question of the factor that all actuators share, or None."""
    if fitted.alike is None:
        return None
    centre, spread = fitted.alike
    for factor, of_masses, of_forces, exact in _FACTORS:
        text = of_forces if evidence.recordings.payload is None else of_masses
        near, alike = (_EXACT, _EXACT) if exact else (_NEAR_ONE, _ONE_FACTOR)
        slack = near + spread / np.sqrt(np.isfinite(fitted.compliances).sum())
        if text and spread < alike and abs(centre - np.log(factor)) < slack:
            return text
    return None
