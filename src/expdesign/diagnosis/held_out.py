"""Error on recordings that were not fitted: the rows marked `test`, or cross-validation blocked by series."""

from dataclasses import dataclass, fields, replace

import numpy as np

from expdesign.arrays import BoolArray, rms
from expdesign.diagnosis.cross_validation import blocks_of, last_part
from expdesign.diagnosis.dispersion import widened, widening
from expdesign.diagnosis.options import OPTIONS
from expdesign.estimation.coverage import HeldOutRows
from expdesign.estimation.fit import Data, Fit, fit


@dataclass(frozen=True)
class HeldOut:
    """RMS of whitened residuals, 1 being the noise floor.

    Attributes:
        train_before, train_after: of the base model and the model with effects on the fitted rows.
        test_before, test_after: the same on rows that were not fitted.
        test_surprise: of the model with effects on those rows, every residual divided by the standard deviation that
            its prediction is expected to miss by, √(1 + h) with h the variance that the fitted parameters bring in; 1
            for a model that is right, however few the rows.
        how: in words.
        coverage: share of those readings within the 95 % intervals of the model with effects, that of the prediction
            and the noise of a reading together; of rows marked `test` those of the model file (`Diagnosis.covering`).
            NaN where no prediction is determined.
        later_before, later_after: on the last fifth of the fitted rows, predicted from what came before it; NaN where
            that was not asked for. What imitates something that changes with time shows there, whatever it depends on.
    """

    train_before: float
    train_after: float
    test_before: float
    test_after: float
    test_surprise: float
    how: str
    coverage: float = float("nan")
    later_before: float = float("nan")
    later_after: float = float("nan")

    @property
    def refuted(self) -> bool:
        """Whether the base model predicts rows that were not fitted better, or clearly better those that come later.

        Those are few, and what predicts them nearly to the noise is not refuted by them.
        """
        later = self.later_after > OPTIONS.clearly * max(self.later_before, OPTIONS.predicts)
        return self.test_after > self.test_before or later

    def divided_by(self, level: float) -> "HeldOut":
        """The same errors in units of another noise level, given as a multiple of the present one."""
        errors = [one.name for one in fields(self) if one.name not in ("how", "coverage")]
        return replace(self, **{name: getattr(self, name) / level for name in errors})


def held_out(
    base: Fit,
    model: Fit,
    sample: Data,
    test: BoolArray,
    *,
    known_noise: bool = True,
    later: bool = True,
) -> HeldOut:
    """Errors of two fitted models on fitted and on held-out rows.

    All rows stay in the history of their series. `known_noise` is for the intervals, as in `widening`; `later` says
    whether the last rows are predicted from those before, which takes further fits.
    """
    kept = sample.counts
    train_before, train_after = (_rms_on(f, sample, kept) for f in (base, model))
    errors = _later(base, model, sample) if later else (float("nan"), float("nan"))
    if test.any():
        rows, how = held_out_rows(model, sample, test), f"{int(test.sum())} rows marked `test`"
        before, after, surprise = _rms_on(base, sample, test), rms(rows.residuals), _surprise(model, rows)
        return HeldOut(train_before, train_after, before, after, surprise, how, float("nan"), *errors)
    folds = blocks_of(sample, OPTIONS.groups)
    squares, within = np.zeros(3), np.zeros(2)
    count = 0
    for fold in range(int(folds.max()) + 1):
        gone = (folds == fold) & kept
        fitted = sample.counting(kept & (folds != fold))
        if not gone.any() or not fitted.counts.any():
            continue
        for index, original in enumerate((base, model)):
            refitted = _refitted(original, fitted)
            squares[index] += _rms_on(refitted, sample, gone) ** 2 * int(gone.sum())
        rows, by = held_out_rows(refitted, sample, gone), widening(refitted, fitted, known_noise=known_noise)
        within += rows.within(widened(refitted, by).estimable, by.readings)
        squares[2] += _surprise(refitted, rows) ** 2 * int(gone.sum())
        count += int(gone.sum())
    before, after, surprise = (float(value) for value in np.sqrt(squares / max(count, 1)))
    how = f"cross-validation in {OPTIONS.groups} blocks of series"
    return HeldOut(train_before, train_after, before, after, surprise, how, _share(*within), *errors)


def _refitted(original: Fit, sample: Data) -> Fit:
    start = original.values if original.chain.effects else None
    return fit(original.chain, sample, start, enough=OPTIONS.settled, rough=0.1 * OPTIONS.settled)


def _later(base: Fit, model: Fit, sample: Data) -> tuple[float, float]:
    """Errors of both on the last fifth, predicted from the rows before it."""
    last, first = last_part(sample, OPTIONS.groups)
    if not (last.any() and first.any()):
        return float("nan"), float("nan")
    before = sample.counting(first)
    errors = [_rms_on(_refitted(each, before), sample, last) for each in (base, model)]
    return errors[0], errors[1]


def held_out_rows(fitted: Fit, sample: Data, chosen: BoolArray) -> HeldOutRows:
    """Rows (N,) that were not fitted, as a fitted model predicts them."""
    residuals, slopes = sample.counting(chosen).residuals_with_sensitivities(fitted.chain, fitted.values)
    return HeldOutRows(residuals[chosen], slopes[chosen])


def _share(part: float, whole: float) -> float:
    return float(part / whole) if whole else float("nan")


def _rms_on(fitted: Fit, sample: Data, chosen: BoolArray) -> float:
    everything = sample.counting(np.ones(len(sample.counts), dtype=bool))
    return rms(everything.residuals(fitted.chain, fitted.values), chosen)


def _surprise(fitted: Fit, rows: HeldOutRows) -> float:
    """RMS of whitened residuals of rows that were not fitted, each divided by its expected size √(1 + s·Σ·sᵀ).

    Ignorance excuses at most as much as the noise does: s·Σ·sᵀ counts up to 1, and parameters that the fitted rows do
    not determine count as known. A fit that explodes on held-out rows is never an explanation.
    """
    s = rows.sensitivities[..., fitted.determined]
    covariance = fitted.covariance[np.ix_(fitted.determined, fitted.determined)]
    expected = 1.0 + np.minimum(np.einsum("nkp,pq,nkq->nk", s, covariance, s), 1.0)
    return rms(rows.residuals / np.sqrt(expected))
