"""Weighted non-linear least squares on the measurement chain, with exact sensitivities."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, as_matrix
from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.identified import ChainBeside, Identified
from expdesign.chain.models.estimable import Estimable
from expdesign.chain.readings.reading import DEFLECTION, Reading
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import RowData
from expdesign.estimation.descent import Descent
from expdesign.estimation.shared_noise import SharedNoise
from expdesign.estimation.whitening import Whitening
from expdesign.mechanics.robots.robot import Robot

RANK_TOLERANCE = 1e-9
"""Singular values of the scaled sensitivities below this fraction of the largest count as zero."""
CONVERGED = 1e-10
"""Relative fall of the sum of squares below which a fit has settled."""
_ROUNDING = 1e-6
"""Standard deviations; see `_above_rounding`."""
_ROUNDED_DATA = 1e-7
"""Singular values of the scaled sensitivities below this fraction of the largest may be the rounding of a file."""
IDLE_DEVIATION = 1.0
"""Relative standard deviation of the compliance of an idle actuator, which stays that of the robot file."""


@dataclass(frozen=True)
class Data:
    """What a fit compares the chain with.

    Attributes:
        recordings: the recordings.
        rows: the same rows as the chain reads them.
        whitening: of their residuals.
        idle: actuators that no row loads (`estimability.idle_actuators`), shape (n_p,); None where all must be loaded.
        reading: what the readings are of.
        identified: what a calibration has found, which belongs to the base model; None for nothing.
        marked: rows that count, shape (N,), in recordings of which others are held out or set aside; None where all do.
            All stay in the chain, because effects with memory need the whole history of a series; residuals and
            sensitivities of a row that does not count are zero.
        shared: noise that readings share beyond that of the whitening; None for none.
    """

    recordings: Recordings
    rows: RowData
    whitening: Whitening
    idle: BoolArray | None = field(default=None, kw_only=True)
    reading: Reading = field(default=DEFLECTION, kw_only=True)
    identified: Identified | None = field(default=None, kw_only=True)
    marked: BoolArray | None = field(default=None, kw_only=True)
    shared: SharedNoise | None = field(default=None, kw_only=True)

    @cached_property
    def counts(self) -> BoolArray:
        """Rows that count, shape (N,)."""
        return np.ones(len(self.recordings), dtype=bool) if self.marked is None else self.marked

    @property
    def kept(self) -> BoolArray:
        """Which of all readings count, row after row, shape (N·k,)."""
        return np.repeat(self.counts, len(self.recordings.axes))

    @property
    def readings(self) -> int:
        """Number of readings that count."""
        return int(self.counts.sum()) * len(self.recordings.axes)

    def counting(self, counts: BoolArray) -> "Data":
        """The same recordings, of which these rows count, shape (N,)."""
        return replace(self, marked=counts)

    def restricted(self, counts: BoolArray) -> "Data":
        """The rows of these that also count in `counts`."""
        return self.counting(self.counts & counts)

    def whiten(self, values: FloatArray) -> FloatArray:
        """Whitened values (N, k, ...), zero for rows that do not count."""
        found = self._weighing.apply(values)
        if self.marked is not None:
            found = found * self.marked.reshape(-1, *(1,) * (found.ndim - 1))
        return found if self.shared is None else self.shared.among(found, self.kept)

    @cached_property
    def _weighing(self) -> Whitening:
        """The whitening, in which rows that do not count share no error of the loads with those that do."""
        loads = self.whitening.loads
        if loads is None or self.marked is None or self.marked.all():
            return self.whitening
        return self.whitening.weighing(loads.among(self.marked))

    def chain(self, robot: Robot, effects: Sequence[Effect] = ()) -> Chain:
        """The chain of a robot that such readings are compared with, with effects beside the base model."""
        if self.identified is None:
            return Chain(robot, tuple(effects), reading=self.reading)
        return self.identified.beside(effects)

    def held(self, robot: Robot, effects: Sequence[Effect], values: FloatArray) -> tuple[Chain, FloatArray]:
        """The chain on which what was identified is held, and its parameters of those (p,) of the chain with it."""
        chain = self.chain(robot, effects)
        return (chain.held, chain.without_identified(values)) if isinstance(chain, ChainBeside) else (chain, values)

    def residuals(self, chain: Chain, values: FloatArray) -> FloatArray:
        """Whitened measured minus predicted readings (N, k)."""
        predicted = chain.predict(self.rows, values)[:, self.recordings.axes]
        return self.whiten(self.recordings.deflections - predicted)

    def residuals_with_sensitivities(self, chain: Chain, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Whitened residuals (N, k) and whitened derivatives of the prediction (N, k, p)."""
        predicted, sensitivities = chain.predict_with_sensitivities(self.rows, values)
        if self.idle is not None:
            # What is left of them is rounding.
            sensitivities[..., np.flatnonzero(self.idle)] = 0.0
        axes = self.recordings.axes
        return self.whiten(self.recordings.deflections - predicted[:, axes]), self.whiten(sensitivities[:, axes])


@dataclass(frozen=True)
class Fit:
    """A fitted chain.

    Attributes:
        chain: the model.
        values: its parameters, shape (p,).
        estimable: the covariance of every combination of parameters that the data determine, with the noise level as
            whitened.
        residuals: whitened, shape (N, k).
        sensitivities: whitened derivatives of the prediction, shape (N, k, p).
        chi2: sum of squared whitened residuals, those of a prior included.
        dof: readings (a prior's included) minus rank.
        rank: of the sensitivities.
        inflation: factor on the covariance beyond what the whitened readings alone would give, where the noise was
            learnt with the parameters.
    """

    chain: Chain
    values: FloatArray
    estimable: Estimable
    residuals: FloatArray
    sensitivities: FloatArray
    chi2: float
    dof: int
    rank: int
    inflation: float = 1.0

    @property
    def covariance(self) -> FloatArray:
        """Of the parameters, infinite in rows of those that the data do not determine, shape (p, p)."""
        return self.estimable.covariance

    @property
    def determined(self) -> BoolArray:
        """Which parameters the data determine, shape (p,)."""
        return self.estimable.determined

    @property
    def freedom(self) -> int:
        """Degrees of freedom of the sum of squared residuals alone: readings minus all that was fitted to them.

        E(rᵀr) = N − tr(H) with the hat matrix H = S·P·Sᵀ. Without a prior tr(H) is the rank; a parameter that its prior
        holds takes nothing from the readings, and one that the readings alone determine takes one. Markers and the
        instrument's frame are among the parameters.
        """
        sensitivities = as_matrix(self.sensitivities)
        fitted = float(((sensitivities @ self.estimable.generalised) * sensitivities).sum()) / self.inflation
        return self.residuals.size - round(min(max(fitted, 0.0), float(min(sensitivities.shape))))

    def seen_by(self, rows: BoolArray) -> "Fit":
        """The same fit with the residuals and sensitivities of some rows (N,) alone: those that counted."""
        return replace(self, residuals=self.residuals[rows], sensitivities=self.sensitivities[rows])

    def known_as(self, estimable: Estimable) -> "Fit":
        """The same fit with another covariance of what the data determine."""
        return replace(self, estimable=estimable)


def fit(
    chain: Chain,
    data: Data,
    start: FloatArray | None = None,
    prior: tuple[FloatArray, FloatArray] | None = None,
    *,
    enough: float = 0.0,
    rough: float = 0.0,
) -> Fit:
    """The parameters that minimise the sum of squared whitened residuals, within their bounds.

    The base model is linear in the compliances and is solved in one step (`linear_fit`); with effects, a trust-region
    method starts from `start`.

    Args:
        chain: the model.
        data: what it is compared with.
        start: parameters to start from; neutral effects if left out.
        prior: mean and standard deviation of the parameters, shape (p,) each (infinite where there is no prior).
        enough: fall of the sum of squares in one step below which a fit has settled, beside `CONVERGED`.
        rough: the same as a share of what the fit leaves beyond the noise: what is wrong by far need not be exact.
    """
    start = chain.start() if start is None else start
    if prior is None:
        prior = chain.knowledge()
        idle = None if data.idle is None else idle_knowledge(data.idle, len(chain.parameters))
        if idle is not None:
            prior = idle if prior is None else (prior[0], np.minimum(prior[1], idle[1]))
    if chain.linear:
        residuals, sensitivities = data.residuals_with_sensitivities(chain, start)
        return linear_fit(chain, start, residuals, sensitivities, prior)
    result = summarise(chain, data, _minimise(chain, data, start, prior, enough, rough), prior)
    if chain.reading.linear and not result.determined.all():
        result = _least(result, data, prior)
    if chain.reading.degeneracies:
        # Held is not known: what depends on it is as uncertain as it is.
        uncertain = summarise(chain, data, result.values, chain.knowledge(released=True))
        result = result.known_as(uncertain.estimable)
    return result


def _least(found: Fit, data: Data, prior: tuple[FloatArray, FloatArray] | None) -> Fit:
    """The same fit, as near to neutral as it can be in typical sizes of the parameters, where some are not determined.

    Steps are scaled by how much each parameter moves the readings, so that what two of them do alike is shared out
    by readings and not by size: one that hardly shows becomes huge, and predictions under loads of another kind
    explode. Along what the data do not determine the least parameters are taken instead.
    """
    scales = found.chain.scales()
    matrix = _scaled(found.sensitivities, scales)
    if prior is not None:
        matrix = np.vstack([matrix, np.diag(scales / prior[1])])
    columns = np.linalg.norm(matrix, axis=0)
    shown = columns > 0.0
    if not shown.any():
        return found
    reduced: FloatArray = np.asarray(np.linalg.qr(matrix[:, shown] / columns[shown], mode="r"))
    _, singular, right = np.linalg.svd(reduced)
    singular = np.concatenate([singular, np.zeros(len(right) - len(singular))])
    hidden = right[singular < _ROUNDED_DATA * singular[0]] / columns[shown]
    if not len(hidden):
        return found
    across: FloatArray = np.asarray(np.linalg.qr(hidden.T)[0])
    away = (found.values - found.chain.start())[shown] / scales[shown]
    values = found.values.copy()
    values[shown] -= across @ (across.T @ away) * scales[shown]
    nearer = summarise(found.chain, data, np.clip(values, *found.chain.bounds()), prior)
    # What is not linear, or a bound, may stand in the way.
    return nearer if nearer.chi2 <= found.chi2 + _ROUNDING * max(found.chi2, 1.0) else found


def idle_knowledge(idle: BoolArray, parameters: int) -> tuple[FloatArray, FloatArray] | None:
    """Mean and standard deviation of all parameters (p,) each: idle actuators as the robot file has them, else nothing.

    None where no actuator is idle.
    """
    if not idle.any():
        return None
    deviation = np.full(parameters, np.inf)
    deviation[: len(idle)][idle] = IDLE_DEVIATION
    return np.ones(parameters), deviation


def _minimise(
    chain: Chain,
    data: Data,
    start: FloatArray,
    prior: tuple[FloatArray, FloatArray] | None,
    enough: float,
    rough: float,
) -> FloatArray:
    """Parameters at the minimum; `summarise` works on the sensitivities themselves."""
    scales = chain.scales()

    def linearised(values: FloatArray) -> tuple[FloatArray, FloatArray]:
        residuals, sensitivities = data.residuals_with_sensitivities(chain, values)
        matrix = as_matrix(sensitivities)
        return residuals.ravel(), matrix * _above_rounding(matrix, scales)

    mean, deviation = prior or (start, np.full(len(start), np.inf))
    descent = Descent(linearised, start, mean, *chain.bounds())

    def settled(cost: float) -> float:
        noise = np.count_nonzero(descent.residuals) + np.count_nonzero((descent.values != mean) / deviation)
        return max(CONVERGED * cost, enough, rough * (cost - noise))

    descent.run(1.0 / deviation**2, settled)
    return descent.values


def _above_rounding(matrix: FloatArray, scales: FloatArray) -> FloatArray:
    """Columns of sensitivities (M, p) that are more than rounding, 1 or 0, shape (p,).

    A parameter that would have to be a million times its typical size to move the readings, all together, by one
    standard deviation is not determined by them.
    """
    return (np.linalg.norm(matrix, axis=0) * scales >= _ROUNDING).astype(float)


def _scaled(sensitivities: FloatArray, scales: FloatArray) -> FloatArray:
    """Sensitivities (N, k, p) per scaled parameter that are more than rounding, shape (N·k, p)."""
    matrix = as_matrix(sensitivities)
    return matrix * (scales * _above_rounding(matrix, scales))


def linear_fit(
    chain: Chain,
    start: FloatArray,
    residuals: FloatArray,
    sensitivities: FloatArray,
    prior: tuple[FloatArray, FloatArray] | None = None,
) -> Fit:
    """The fit of a chain that is linear in its parameters, from its linearisation anywhere.

    Args:
        chain: the model.
        start: parameters at which it was linearised, shape (p,).
        residuals: whitened residuals there, shape (N, k).
        sensitivities: whitened derivatives of the prediction, shape (N, k, p).
        prior: see `fit`.
    """
    scales = chain.scales()
    matrix = _scaled(sensitivities, scales)
    step, estimable, rank = _solve(matrix, residuals.ravel(), start, scales, prior)
    remaining = residuals - sensitivities @ (step * scales)
    return _as_fit(chain, start + step * scales, estimable, rank, remaining, sensitivities, prior)


def summarise(chain: Chain, data: Data, values: FloatArray, prior: tuple[FloatArray, FloatArray] | None = None) -> Fit:
    """The fit at given parameter values."""
    residuals, sensitivities = data.residuals_with_sensitivities(chain, values)
    scales = chain.scales()
    matrix = _scaled(sensitivities, scales)
    _, estimable, rank = _solve(matrix, residuals.ravel(), values, scales, prior)
    return _as_fit(chain, values, estimable, rank, residuals, sensitivities, prior)


def _as_fit(
    chain: Chain,
    values: FloatArray,
    estimable: Estimable,
    rank: int,
    residuals: FloatArray,
    sensitivities: FloatArray,
    prior: tuple[FloatArray, FloatArray] | None,
) -> Fit:
    """A prior counts as readings of the parameters it is about."""
    chi2, readings = float((residuals**2).sum()), residuals.size
    if prior is not None:
        chi2 += float((((prior[0] - values) / prior[1]) ** 2).sum())
        readings += int(np.isfinite(prior[1]).sum())
    return Fit(chain, values, estimable, residuals, sensitivities, chi2, readings - rank, rank)


def _solve(
    matrix: FloatArray,
    residuals: FloatArray,
    values: FloatArray,
    scales: FloatArray,
    prior: tuple[FloatArray, FloatArray] | None,
) -> tuple[FloatArray, Estimable, int]:
    """Gauss-Newton step in units of `scales`, what is estimable, and the rank."""
    if prior is not None:
        matrix = np.vstack([matrix, np.diag(scales / prior[1])])
        residuals = np.concatenate([residuals, (prior[0] - values) / prior[1]])
    # The orthogonal factor is not needed: R of [Ã | r] holds Qᵀr as well, and is as small as the problem.
    count = matrix.shape[1]
    columns = np.linalg.norm(matrix, axis=0)
    safe = np.where(columns > 0.0, columns, 1.0)
    stacked = np.column_stack([matrix / safe, residuals])
    missing = count + 1 - len(stacked)
    if missing > 0:
        stacked = np.vstack([stacked, np.zeros((missing, count + 1))])
    reduced: FloatArray = np.asarray(np.linalg.qr(stacked, mode="r"))
    left, singular, right = np.linalg.svd(reduced[:count, :count])
    kept = singular > RANK_TOLERANCE * (singular[0] if singular.size else 1.0)
    rank = int(kept.sum())
    step = (right[kept].T / singular[kept]) @ (left[:, kept].T @ reduced[:count, count]) / safe
    resolution = scales / safe
    root = (right[kept].T / singular[kept]) * resolution[:, None]
    estimable = Estimable(root @ root.T, right[~kept].T * resolution[:, None], resolution)
    return step, estimable, rank
