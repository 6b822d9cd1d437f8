"""Statistics of a diagnosed fit: dispersion of its residuals, its test (that of `identify`), and wider predictions.

`dispersion` says how much less the residuals of a model tell than as many independent rows with the stated noise would.
Residuals that exceed their standard deviations, and residuals of consecutive rows that are alike (filtered or densely
sampled recordings, and whatever the model leaves out), carry less information than their number. With lag-one
correlation ρ the effective number of rows is N·(1 − ρ)/(1 + ρ) (first-order autoregression), and the covariance of the
parameters grows by the mean square of the residuals times (1 + ρ)/(1 − ρ).

The covariance of a fit is that of a form which is the machine's own. The library's is another, whose predictions are
wrong by a share √q of what the physics does to them, however many the rows: with v_k the deviation of the parameters of
effect k from none, predictions have the covariance C + q·Σ_k v_k·v_kᵀ. q is what left-out readings ask for
(`LeftOut.widened`, with Σ_k (A·v_k)² in the place of the prior variance of laws).
"""

from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.ports.law import Law
from expdesign.estimation.fit import Data, Fit, linear_fit
from expdesign.estimation.goodness import StatementOfFit, noise_ratio, squares_of, statement_of_fit
from expdesign.estimation.noise_level import NoiseLevel

_STRONGEST = 0.98
_FEWEST = 20
"""Pairs of consecutive rows below which a correlation is not estimated."""


@dataclass(frozen=True)
class Dispersion:
    """Mean square of the residuals (1: noise as stated), correlation of consecutive rows, and the number of rows."""

    mean_square: float
    correlation: float
    rows: int

    @property
    def effective_rows(self) -> float:
        """Number of independent rows that would say as much."""
        return self.rows * (1.0 - self.correlation) / (1.0 + self.correlation)

    @property
    def inflation(self) -> float:
        """Factor on the covariance of the parameters, at least 1."""
        return max(1.0, self.mean_square) * (1.0 + self.correlation) / (1.0 - self.correlation)


def dispersion(residuals: FloatArray, sample: Data) -> Dispersion:
    """Dispersion of whitened residuals (N, k) over the rows that count, in the order of recording within series."""
    counts = sample.counts
    rows = np.flatnonzero(counts)
    mean_square = float((residuals[rows] ** 2).mean())
    series = sample.recordings.series
    together = (np.diff(rows) == 1) & (series[rows[1:]] == series[rows[:-1]])
    before, after = residuals[rows[:-1][together]], residuals[rows[1:][together]]
    if len(before) < _FEWEST or mean_square == 0.0:
        return Dispersion(mean_square, 0.0, len(rows))
    squares = 0.5 * ((before**2).sum() + (after**2).sum())
    correlation = float((before * after).sum() / max(float(squares), 1e-300))
    return Dispersion(mean_square, float(np.clip(correlation, 0.0, _STRONGEST)), len(rows))


def statement(fit: Fit, sample: Data, noise: NoiseLevel) -> StatementOfFit:
    """Whether a model accounts for the rows that count, `noise` being that of all rows.

    Where errors of their loads are weighed, χ² with exact loads is that of the model linear about its estimate.
    """
    counts, recordings = sample.counts, sample.recordings
    columns = recordings.components(fit.chain.robot.coordinates)
    whitening = sample.whitening.rows(counts)
    of_rows = replace(noise, deviations=noise.deviations[counts])
    seen, rows = fit.seen_by(counts), recordings.rows(counts)
    exact = None if whitening.loads is None else squares_of(_with_exact_loads(fit, sample).seen_by(counts))[0]
    return statement_of_fit(seen, rows, of_rows, whitening, columns, exact)


def _with_exact_loads(fit: Fit, sample: Data) -> Fit:
    plain = replace(sample, whitening=sample.whitening.weighing(None))
    residuals, sensitivities = plain.residuals_with_sensitivities(fit.chain, fit.values)
    return linear_fit(fit.chain, fit.values, residuals, sensitivities, fit.chain.knowledge())


def tested(fit: Fit, sample: Data) -> tuple[float, int]:
    """χ² of the rows that count, and its degrees of freedom, at least 1."""
    value, dof = squares_of(fit.seen_by(sample.counts))
    return value, max(dof, 1)


@dataclass(frozen=True)
class Widening:
    """By what the residuals of a fit widen its predictions.

    Attributes:
        readings: factor on the standard deviation of a reading (the Birge ratio, smaller than 1 where the stated one is
            too large; where the noise is estimated, what the model leaves over).
        parameters: factor on those of the parameters: the same, and what consecutive rows that are alike do not say.
    """

    readings: float = 0.0
    parameters: float = 0.0


NONE = Widening()


def widening(fit: Fit, sample: Data, *, known_noise: bool, left_out: Widening = NONE) -> Widening:
    """The widening that the rows which count ask for.

    Args:
        fit: the model.
        sample: the rows that it was fitted to.
        known_noise: whether the standard deviations of the readings are stated.
        left_out: what blocks ask for that were left out, where that is known: readings of a machine with many small
            errors scatter about its predictions as these do, and not as fitted ones.
    """
    value, dof = tested(fit, sample)
    ratio = noise_ratio(value, dof) if known_noise else sqrt(value / dof)
    spread = dispersion(fit.residuals, sample)
    alike = sqrt((1.0 + spread.correlation) / (1.0 - spread.correlation))
    # Where the noise was learnt with the parameters, they are known by it as well, else no better than stated.
    level = max(ratio, 1.0) if known_noise and left_out == NONE else ratio
    return Widening(max(ratio, left_out.readings), max(level * alike, left_out.parameters))


def widened(fit: Fit, by: Widening) -> Fit:
    """The fit with the covariance that predictions are made with; what is in it already is not taken twice."""
    factor = max(by.parameters**2 / fit.inflation, 1.0) if fit.inflation != 1.0 else by.parameters**2
    return replace(fit.known_as(fit.estimable.scaled(factor)), inflation=fit.inflation * factor)


def deviations_from_none(fit: Fit) -> FloatArray:
    """The v_k of a model as columns, shape (p, K): its effects, or its compliances where it has none.

    Every weight of a law counts by itself, with its standard deviation beforehand.
    """
    count = len(fit.values)
    columns: list[FloatArray] = []
    for effect, part in zip(fit.chain.effects, fit.chain.slices, strict=True):
        if isinstance(effect, Law):
            columns += list(effect.form.deviation * np.eye(count)[part])
        else:
            free = np.array([not parameter.shape for parameter in effect.parameters])
            column = np.zeros(count)
            column[part] = np.where(free, fit.values[part] - effect.neutral(), 0.0)
            columns.append(column)
    return np.column_stack(columns) if columns else np.diag(fit.values)


def with_share(fit: Fit, share: float) -> Fit:
    """The fit with the covariance C + q·Σ_k v_k·v_kᵀ."""
    moved, known = deviations_from_none(fit), fit.estimable
    return fit.known_as(replace(known, generalised=known.generalised + share * (moved @ moved.T)))
