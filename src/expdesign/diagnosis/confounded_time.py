"""Drifts that show only because something else changed with time.

`confounded_with` says what else changed with time, `drift_tests` whether a drift shows apart from it.

Where poses were visited in an order, say lift after lift, whatever changes with the lift changes with time as well, and
a drift of the instrument describes it. Let t̂ = E[t | x] be the prediction of time by one quantity x (means of the
levels of x, or a parabola), R² its share of the variance of time. Where R² is large, the drift is fitted together with
the same drift along t̂: only what follows t − t̂, time among rows that are alike in x, is evidence of a drift (the
variance inflation factor of time is 1/(1 − R²): D. A. Belsley, E. Kuh, R. E. Welsch, Regression Diagnostics, 1980,
section 3.2).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2 as chi2_distribution

from expdesign.arrays import BoolArray, FloatArray, as_matrix
from expdesign.chain.row import RowData, row_data
from expdesign.diagnosis.locate import drivers, orthonormal_basis
from expdesign.diagnosis.names import NamedModel, Names
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.sample import Sample
from expdesign.mechanics.robots.robot import Robot

_LEVELS = 12
"""Values of a quantity up to which each is a level of its own."""
_DRIFTS = "thermal_drift"
_OF_TIME = {"time_s", "order of recording", "place in the series", "temperature_degC", "loading against unloading"}


@dataclass(frozen=True)
class Confounded:
    """What changed with time.

    Attributes:
        name: of the quantity.
        share: R² of time on it.
        predicted: t̂ of every row (s, or rows), shape (N,).
    """

    name: str
    share: float
    predicted: FloatArray


@dataclass(frozen=True)
class DriftTest:
    """Whether a drift of a model shows apart from what changed with time.

    Attributes:
        index: of the effect in the model.
        shows: whether it does.
        p_value: of no drift along t − t̂.
    """

    index: int
    shows: bool
    p_value: float


def confounded_with(sample: Sample, robot: Robot) -> Confounded | None:
    """The quantity that predicts the times of the rows best, where it predicts nearly all of their variance."""
    counts = sample.counts
    time = _times(sample)
    best: Confounded | None = None
    for name, values in drivers(sample, robot).items():
        if name in _OF_TIME or name in sample.recordings.extra.columns:
            continue
        predicted = _predicted(time, values, counts)
        if predicted is None:
            continue
        variance = float(time[counts].var())
        share = 1.0 - float(((time - predicted)[counts] ** 2).mean()) / variance if variance > 0.0 else 0.0
        if share >= OPTIONS.nearly and (best is None or share > best.share):
            best = Confounded(name, share, predicted)
    return best


def drift_tests(names: Names, model: NamedModel, other: Confounded) -> list[DriftTest]:
    """A test of every drift of a model beside the same drift along t̂ and the model's other effects."""
    found = []
    for index, candidate in enumerate(model.candidates):
        if candidate.effect.physics == _DRIFTS and _follows_time(names, model, index, other):
            found.append(_drift_test(names, model, index, other))
    return found


def unsupported(names: Names, model: NamedModel, other: Confounded | None) -> tuple[str, ...]:
    """Keys of a model's drifts that do not show apart from what changed with time."""
    if other is None:
        return ()
    tests = drift_tests(names, model, other)
    return tuple(model.candidates[test.index].effect.key for test in tests if not test.shows)


def _times(sample: Sample) -> FloatArray:
    time = sample.recordings.time
    return np.arange(len(sample.counts), dtype=float) if time is None else time - time[0]


def _predicted(time: FloatArray, values: FloatArray, counts: BoolArray) -> FloatArray | None:
    """Prediction of time from a quantity by its levels, or by a parabola; None where every row is a level."""
    rounded = np.round(values / max(float(np.ptp(values[counts])), 1e-300), 3)
    levels, index = np.unique(rounded, return_inverse=True)
    if len(levels) <= min(_LEVELS, int(counts.sum()) // 5):
        design = np.eye(len(levels))[index]
    else:
        scaled = (values - values.mean()) / max(float(values.std()), 1e-300)
        design = np.vander(scaled, 3)
    if int(counts.sum()) < 3 * design.shape[1]:
        return None
    weights = np.linalg.lstsq(design[counts], time[counts], rcond=None)[0]
    predicted: FloatArray = design @ weights
    return predicted


def _along(names: Names, model: NamedModel, other: Confounded) -> RowData:
    """The rows as they would be had they been recorded at t̂."""
    recordings = names.sample.recordings
    if recordings.time is not None:
        return row_data(replace(recordings, time=other.predicted), names.robot)
    rows = row_data(recordings, names.robot)
    values = rows.values.copy()
    values[:, model.fit.chain.row_symbols().columns("number")] = other.predicted[:, None]
    return replace(rows, values=values)


def _directions(names: Names, model: NamedModel, index: int, rows: RowData) -> FloatArray:
    """Whitened derivatives (M, d) of the readings by a drift's parameters, in rows at other times."""
    chain, part = model.fit.chain, model.fit.chain.slices[index]
    axes = names.sample.recordings.axes
    slopes = chain.predict_with_sensitivities(rows, model.fit.values)[1][:, axes, part]
    free = [not parameter.shape for parameter in model.candidates[index].effect.parameters]
    counts = names.sample.restricted(~model.outliers)
    return as_matrix(counts.whiten(slopes))[:, free]


def _follows_time(names: Names, model: NamedModel, index: int, other: Confounded) -> bool:
    """Whether a drift is one along time, not along temperature."""
    own = _directions(names, model, index, names.sample.rows)
    return not np.allclose(own, _directions(names, model, index, _along(names, model, other)))


def _drift_test(names: Names, model: NamedModel, index: int, other: Confounded) -> DriftTest:
    own = _directions(names, model, index, names.sample.rows)
    rival = _directions(names, model, index, _along(names, model, other))
    smaller = names.without(model, index)
    basis = orthonormal_basis(np.hstack([as_matrix(smaller.fit.sensitivities), rival]))
    residuals = smaller.fit.residuals.ravel()
    own_free = own - basis @ (basis.T @ own)
    sizes = np.linalg.norm(own_free, axis=0)
    shown = sizes > 1e-6 * np.linalg.norm(own, axis=0)
    if not shown.any():
        return DriftTest(index, False, 1.0)
    within, _, rank, _ = np.linalg.lstsq(own_free[:, shown], residuals, rcond=1e-9)
    gain = float(residuals @ (own_free[:, shown] @ within))
    # What neither explains is larger than the noise where more is missing; it must not count as evidence.
    left = residuals - basis @ (basis.T @ residuals) - own_free[:, shown] @ within
    variance = float(left @ left) / max(names.sample.readings - basis.shape[1] - rank, 1)
    variance = max(variance, 1.0 if names.known_noise else 1e-300)
    p_value = float(chi2_distribution.sf(gain / variance, max(int(rank), 1)))
    alone = model.fit.values[model.fit.chain.slices[index]]
    free = np.array([not parameter.shape for parameter in model.candidates[index].effect.parameters])
    whole = (alone[free] * sizes)[shown]
    share = float((within * sizes[shown]) @ whole) / max(float(whole @ whole), 1e-300)
    return DriftTest(index, p_value < OPTIONS.level and share > OPTIONS.half, p_value)
