"""A smooth correction for a mismatch that no physics explains: Gaussian-process regression of the residuals.

It is an interpolation and says nothing about causes; whether it may be used is decided by the same held-out error as
for physics. Inputs are pose, load and time, each scaled to unit spread; the kernel is a squared exponential, the same
for all axes, whose length, amplitude and noise maximise the marginal likelihood.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.diagnosis.held_out import folds_of
from expdesign.diagnosis.sample import Sample, rms
from expdesign.identification.fit import Fit

_EXTREME = 20.0
"""Logarithms of settings beyond which a search has gone astray."""
HELPS = 0.98
"""Factor on held-out RMS below which a correction is worth having; less is chance."""
MOST_ROWS = 1500
"""Rows from which the regression learns; more would cost time, not add accuracy."""


@dataclass(frozen=True)
class SmoothCorrection:
    """What a smooth correction of the residuals would do.

    Attributes:
        test_before, test_after: RMS of held-out residuals without and with it (1: noise).
        correction: whitened correction at every row, from all rows that count, shape (N, k).
        scaled_length: length over which residuals are alike, in spreads of the inputs.
        amplitude: of the correction, in standard deviations of the readings.
    """

    test_before: float
    test_after: float
    correction: FloatArray
    scaled_length: float
    amplitude: float

    @property
    def helps(self) -> bool:
        """Whether held-out recordings are predicted noticeably better with it."""
        return self.test_after < HELPS * self.test_before


def smooth_correction(fitted: Fit, sample: Sample, test: BoolArray) -> SmoothCorrection:
    """The correction of a fitted model's residuals, learnt from the rows that count and judged on held-out ones."""
    everything = Sample.of(sample, np.ones(len(sample.counts), dtype=bool))
    residuals = everything.residuals(fitted.chain, fitted.values)
    inputs = _inputs(sample)
    known = np.flatnonzero(sample.counts)[:MOST_ROWS]
    settings = _settings(inputs, residuals, known)
    correction = _regress(inputs, residuals, known, settings, np.arange(len(residuals)))
    if test.any():
        left = np.flatnonzero(test)
        after = rms(residuals - correction, test)
        return SmoothCorrection(rms(residuals[left], np.ones(len(left), bool)), after, correction, *settings[:2])
    held = np.zeros_like(residuals)
    folds = folds_of(sample)
    for fold in range(int(folds.max()) + 1):
        learn = known[folds[known] != fold]
        left = np.flatnonzero((folds == fold) & sample.counts)
        if learn.size and left.size:
            held[left] = _regress(inputs, residuals, learn, settings, left)
    before = rms(residuals, sample.counts)
    return SmoothCorrection(before, rms(residuals - held, sample.counts), correction, *settings[:2])


def _inputs(sample: Sample) -> FloatArray:
    """Pose, load and time of every row, scaled to unit spread, constant ones left out, shape (N, d)."""
    recordings = sample.recordings
    time = recordings.time if recordings.time is not None else recordings.sequence.astype(float)
    columns = np.column_stack([recordings.configurations, recordings.wrenches, time])
    spread = columns.std(axis=0)
    varying = spread > 1e-12 * np.maximum(np.abs(columns).max(axis=0), 1e-300)
    scaled: FloatArray = (columns[:, varying] - columns[:, varying].mean(axis=0)) / spread[varying]
    return scaled


def _settings(inputs: FloatArray, residuals: FloatArray, known: IntArray) -> tuple[float, float, float]:
    """Length, amplitude and noise that maximise the marginal likelihood of the residuals of all axes."""
    distances = _squared_distances(inputs[known], inputs[known])
    values = residuals[known]

    def misfit(logs: FloatArray) -> float:
        length, amplitude, noise = np.exp(np.clip(logs, -_EXTREME, _EXTREME))
        matrix = amplitude**2 * np.exp(-0.5 * distances / length**2) + noise**2 * np.eye(len(known))
        try:
            factor = cho_factor(matrix, lower=True)
        except np.linalg.LinAlgError:
            return 1e12
        logarithm = 2.0 * np.log(factor[0].diagonal()).sum()
        return float((values * cho_solve(factor, values)).sum() + values.shape[1] * logarithm)

    start = np.log([np.sqrt(inputs.shape[1]), max(float(values.std()), 1e-3), 1.0])
    result = minimize(misfit, start, method="Nelder-Mead", options={"maxiter": 60, "xatol": 0.05, "fatol": 0.1})
    length, amplitude, noise = np.exp(np.clip(result.x, -_EXTREME, _EXTREME))
    return float(length), float(amplitude), float(noise)


def _regress(
    inputs: FloatArray,
    residuals: FloatArray,
    known: IntArray,
    settings: tuple[float, float, float],
    at: IntArray,
) -> FloatArray:
    """Mean of the Gaussian process at rows `at`, learnt from rows `known`, shape (len(at), k)."""
    length, amplitude, noise = settings
    within = amplitude**2 * np.exp(-0.5 * _squared_distances(inputs[known], inputs[known]) / length**2)
    across = amplitude**2 * np.exp(-0.5 * _squared_distances(inputs[at], inputs[known]) / length**2)
    factor = cho_factor(within + noise**2 * np.eye(len(known)), lower=True)
    mean: FloatArray = across @ cho_solve(factor, residuals[known])
    return mean


def _squared_distances(a: FloatArray, b: FloatArray) -> FloatArray:
    squares: FloatArray = (a**2).sum(axis=1)[:, None] + (b**2).sum(axis=1)[None, :] - 2.0 * a @ b.T
    return np.maximum(squares, 0.0)
