"""Error on recordings that were not fitted: the rows marked `test`, or cross-validation blocked by series."""

from dataclasses import dataclass, fields, replace

import numpy as np

from expdesign.arrays import BoolArray, rms
from expdesign.diagnosis.cross_validation import blocks_of, last_part, readings_of
from expdesign.diagnosis.dispersion import widening
from expdesign.diagnosis.evidence.state import linearised
from expdesign.diagnosis.options import OPTIONS
from expdesign.estimation.coverage import NORMAL_95, HeldOutRows
from expdesign.estimation.fit import Data, Fit

_UNTOLD = 1e6
"""Variance of a prediction, in variances of the noise, from which it is none."""


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

    Blocks of fitted rows are left out in closed form, by models that are linear about their fits. All rows stay in the
    history of their series. `known_noise` is for the intervals, as in `widening`; `later` says whether the last rows
    are predicted from those before.
    """
    kept = sample.counts
    train_before, train_after = (_rms_on(f, sample, kept) for f in (base, model))
    states = [linearised(f, sample) for f in (base, model)] if later or not test.any() else []
    last = readings_of(last_part(sample, OPTIONS.groups)[0], sample)
    asked = later and last.any() and not last.all()
    ends = [rms(state.left_out(last.astype(int))[last]) for state in states] if asked else []
    later_before, later_after = ends or (float("nan"), float("nan"))
    if test.any():
        rows, how, coverage = held_out_rows(model, sample, test), f"{int(test.sum())} rows marked `test`", float("nan")
        before, after, surprise = _rms_on(base, sample, test), rms(rows.residuals), _surprise(model, rows)
    else:
        blocks = readings_of(blocks_of(sample, OPTIONS.groups), sample)
        how = f"cross-validation in {OPTIONS.groups} blocks of series"
        errors = states[1].left_out(blocks)
        variances = np.maximum(states[1].left_out_variances(blocks) - 1.0, 0.0)
        before, after = rms(states[0].left_out(blocks)), rms(errors)
        surprise = rms(errors / np.sqrt(1.0 + np.minimum(variances, 1.0)))
        by, told = widening(model, sample, known_noise=known_noise), variances < _UNTOLD
        within = np.abs(errors) <= NORMAL_95 * np.hypot(by.readings, by.parameters * np.sqrt(variances))
        coverage = float(within[told].mean()) if told.any() else float("nan")
    return HeldOut(
        train_before, train_after, before, after, surprise, how, coverage, later_before, later_after
    )  # fmt: skip


def held_out_rows(fitted: Fit, sample: Data, chosen: BoolArray) -> HeldOutRows:
    """Rows (N,) that were not fitted, as a fitted model predicts them."""
    residuals, slopes = sample.counting(chosen).residuals_with_sensitivities(fitted.chain, fitted.values)
    return HeldOutRows(residuals[chosen], slopes[chosen])


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
