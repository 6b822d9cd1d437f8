"""Error on recordings that were not fitted: the rows marked `test`, or cross-validation blocked by series."""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, IntArray
from expdesign.diagnosis.sample import Sample, rms
from expdesign.identification.fit import Fit, fit

FOLDS = 5


@dataclass(frozen=True)
class HeldOut:
    """RMS of whitened residuals, 1 being the noise floor.

    Attributes:
        train_before, train_after: of the base model and the model with effects on the fitted rows.
        test_before, test_after: the same on rows that were not fitted.
        how: in words.
    """

    train_before: float
    train_after: float
    test_before: float
    test_after: float
    how: str


def held_out(base: Fit, model: Fit, sample: Sample, test: BoolArray, outliers: BoolArray) -> HeldOut:
    """Errors of two fitted models on fitted and on held-out rows.

    Rows set aside as outliers belong to no physics and count for neither model; all rows stay in the history of their
    series.
    """
    kept = sample.counts & ~outliers
    train_before, train_after = (_rms_on(f, sample, kept) for f in (base, model))
    if test.any():
        before, after = (_rms_on(f, sample, test) for f in (base, model))
        return HeldOut(train_before, train_after, before, after, f"{int(test.sum())} rows marked `test`")
    folds = folds_of(sample)
    squares = np.zeros(2)
    count = 0
    for fold in range(int(folds.max()) + 1):
        left_out = (folds == fold) & kept
        fitted = Sample.of(sample, kept & (folds != fold))
        if not left_out.any() or not fitted.counts.any():
            continue
        for index, original in enumerate((base, model)):
            refitted = fit(original.chain, fitted, original.values if original.chain.effects else None)
            squares[index] += _rms_on(refitted, sample, left_out) ** 2 * int(left_out.sum())
        count += int(left_out.sum())
    before, after = np.sqrt(squares / max(count, 1))
    return HeldOut(
        train_before, train_after, float(before), float(after), f"cross-validation in {FOLDS} blocks of series"
    )


def folds_of(sample: Sample) -> IntArray:
    """Fold of every row: whole series together where there are enough of them, else blocks of consecutive rows."""
    series = sample.rows.series
    if len(np.unique(series)) >= FOLDS:
        return series % FOLDS
    return np.arange(len(series)) * FOLDS // len(series)


def _rms_on(fitted: Fit, sample: Sample, chosen: BoolArray) -> float:
    everything = Sample.of(sample, np.ones(len(sample.counts), dtype=bool))
    return rms(everything.residuals(fitted.chain, fitted.values), chosen)
