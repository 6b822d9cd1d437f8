"""Which named effects are possible: none at the limit of what a machine can be, and no drift that something else makes.

An effect that a fit has driven to its limit describes something else, and is not a name. Nor is a drift that shows only
because something else changed with time: where poses were visited in an order, say lift after lift, whatever changes
with the lift changes with time as well. Let t̂ = E[t | x] be the prediction of time by one quantity x (means of the
levels of x, or a parabola), R² its share of the variance of time. Where R² is large, the same drift along t̂ is a rival
column: only what the drift gains beside it, by what follows t − t̂ among rows that are alike in x, is evidence of it
(the variance inflation factor of time is 1/(1 − R²): D. A. Belsley, E. Kuh, R. E. Welsch, Regression Diagnostics, 1980,
section 3.2).
"""

from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from expdesign.arrays import BoolArray, FloatArray, as_matrix
from expdesign.chain.effect import Effect
from expdesign.chain.ports.law import Law
from expdesign.chain.row import RowData, row_data
from expdesign.diagnosis.evidence.state import Present
from expdesign.diagnosis.locate import drivers
from expdesign.diagnosis.options import OPTIONS
from expdesign.estimation.fit import Data, Fit
from expdesign.mechanics.robots.robot import Robot

_TURNED = 0.5
"""rad; an error of an angle that any drawing would show."""
_LEVELS = 12
"""Values of a quantity up to which each is a level of its own."""
_DRIFTS = "thermal_drift"
_OF_TIME = {"time_s", "order of recording", "place in the series", "temperature_degC", "loading against unloading"}


def at_limit(fit: Fit, reach: float) -> str:
    """The first parameter of named effects at a limit at which they do not vanish, in words; empty without one.

    No machine has a length or an offset of more than twice its `reach` (m), nor an angle off by `_TURNED` (rad).
    """
    for effect, part in zip(fit.chain.effects, fit.chain.slices, strict=True):
        if isinstance(effect, Law):
            continue
        values = fit.values[part]
        # A shape or a phase says where something repeats, not how far off it is.
        shapes = {"phase_rad", *(parameter.name for parameter in effect.parameters if parameter.shape)}
        for name, value in _reported(effect, values).items():
            limit = {"m": 2.0 * reach, "rad": _TURNED}.get(name.rpartition("_")[2], np.inf)
            if abs(value) > limit and name not in shapes and "_per_" not in name:
                return f"{name} of {effect.component}"
        for parameter, value in zip(effect.parameters, values, strict=True):
            limits = {parameter.low, parameter.high} - {parameter.neutral}
            if not parameter.shape and any(np.isclose(value, limit, rtol=1e-9, atol=0.0) for limit in limits):
                return f"{parameter.name} of {effect.component}"
    return ""


def _reported(effect: Effect, values: FloatArray) -> dict[str, float]:
    """What people know of an effect (`Effect.reported`) at values of its parameters (p,)."""
    theta = ca.SX.sym("theta", len(values))
    expressions = effect.reported(theta)
    found = ca.Function("reported", [theta], [ca.vertcat(*expressions.values())])(values)
    return dict(zip(expressions, np.array(found).ravel().tolist(), strict=True))


@dataclass(frozen=True)
class Confounded:
    """What changed with time.

    Attributes:
        name: of the quantity.
        share: R² of time on it.
        rows: as they would be had they been recorded at t̂ (s, or rows).
    """

    name: str
    share: float
    rows: RowData

    def columns(self, fit: Fit, effect: Effect, sample: Data) -> tuple[FloatArray, FloatArray] | None:
        """Directions of a drift of a fit along t and along t̂, (M, d) each; None of what does not follow time."""
        if effect.physics != _DRIFTS:
            return None
        own, rival = (_directions(fit, effect, sample, rows) for rows in (sample.rows, self.rows))
        return None if np.allclose(own, rival) else (own, rival)

    def explains(self, fit: Fit, effect: Effect, sample: Data, rest: Present, price: float) -> bool:
        """Whether an effect is a drift that is not worth its price beside the same drift along t̂.

        Args:
            fit: with the effect.
            effect: of it.
            sample: the rows that count.
            rest: linear about what else is there.
            price: log evidence that the drift has to bring.
        """
        columns = self.columns(fit, effect, sample)
        if columns is None:
            return False
        own, rival = columns
        return rest.beside(rival, rest.gain(rival)[1]).refitted().gain(own)[0] < price


def _directions(fit: Fit, effect: Effect, sample: Data, rows: RowData) -> FloatArray:
    """Whitened derivatives of the readings that count by a drift's parameters, of unit mean square, in some rows."""
    part = fit.chain.slices[fit.chain.effects.index(effect)]
    slopes = fit.chain.predict_with_sensitivities(rows, fit.values)[1][:, sample.recordings.axes, part]
    free = [not parameter.shape for parameter in effect.parameters]
    found = as_matrix(sample.whiten(slopes))[sample.kept][:, free]
    sizes = np.sqrt((found**2).mean(axis=0))
    scaled: FloatArray = found / np.where(sizes > 0.0, sizes, 1.0)
    return scaled


def confounded_with(sample: Data, robot: Robot) -> Confounded | None:
    """The quantity that predicts the times of the rows best, where it predicts nearly all of their variance."""
    counts, recordings = sample.counts, sample.recordings
    time = np.arange(len(counts), dtype=float) if recordings.time is None else recordings.time - recordings.time[0]
    variance = float(time[counts].var())
    best: tuple[float, str, FloatArray] | None = None
    for name, values in drivers(sample, robot).items() if variance > 0.0 else ():
        if name in _OF_TIME or name in recordings.extra.columns:
            continue
        predicted = _predicted(time, values, counts)
        if predicted is None:
            continue
        share = 1.0 - float(((time - predicted)[counts] ** 2).mean()) / variance
        if share >= OPTIONS.nearly and (best is None or share > best[0]):
            best = share, name, predicted
    return None if best is None else Confounded(best[1], best[0], _along(sample, robot, best[2]))


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


def _along(sample: Data, robot: Robot, time: FloatArray) -> RowData:
    """The rows as they would be had they been recorded at other times (N,)."""
    recordings = sample.recordings
    if recordings.time is not None:
        return row_data(replace(recordings, time=time), robot)
    rows = row_data(recordings, robot)
    values = rows.values.copy()
    values[:, sample.chain(robot).row_symbols().columns("number")] = time[:, None]
    return replace(rows, values=values)
