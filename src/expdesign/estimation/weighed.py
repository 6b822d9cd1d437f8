"""Fits that weigh declared load errors, with one scale for every source of them (theory.md 5.6).

The readings less the prediction are r = S·θ + Σ_s G_s·δ_s + e, δ_s ~ N(0, λ_s²·I) in declared standard deviations. The
`generalised` estimate weighs them: its residuals are whitened by C(λ) = V + Σ λ_s²·G_s·G_sᵀ. The `weighted` estimate of
the thesis is that of the noise alone, λ = 0. For either, with its gain K, the covariance is K·C(μ)·Kᵀ, and χ² that of
C(μ), μ being how large the load errors are.

A declaration is a prior: ln μ_s ~ N(0, 0.7²), so that half and twice the declared size are one standard deviation away.
μ is the posterior median (the mode of ln μ), λ the posterior mode of the scale itself, which is smaller: where the
recordings say nothing of a scale the fit weighs 0.61 of the declared size, which costs little whether the declaration
is right or twice too large, and intervals contain all of it. Both are reported.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import minimize

from expdesign.arrays import BoolArray, FloatArray, as_matrix
from expdesign.chain.chain import Chain
from expdesign.chain.models.acting import ActingLoads
from expdesign.chain.models.estimable import Estimable
from expdesign.chain.recordings.recordings import Recordings
from expdesign.estimation.acting_loads import EstimatedLoads, LoadsAtTargets
from expdesign.estimation.fit import Fit
from expdesign.estimation.gaussian import Gaussian
from expdesign.estimation.load_errors import DeclaredLoadErrors, Estimator, LoadEffect, load_columns, shared_parts
from expdesign.estimation.propagated import Propagated, gain_of
from expdesign.estimation.whitening import LoadColumns, Whitening

SCALE_SPREAD = 0.7
"""Standard deviation of the logarithm of a scale about 0."""
_FARTHEST = 5.0
"""Logarithm of the scale at which the search for it ends."""
_ROUNDS = 20
_SETTLED = 1e-4
"""Standard deviations by which parameters move at most once the columns of the load errors have settled."""


@dataclass(frozen=True)
class Fittable:
    """What a fit consists of, at any noise.

    Attributes:
        chain: the model.
        train: the rows that are fitted.
        solve: the fit with a whitening.
        linearised: residuals (N, k) and sensitivities (N, k, p) at parameters (p,), not whitened.
        prior: mean and standard deviation of the parameters (p,), infinite where there is none; None without any.
        counts: which of the rows count, shape (N,), in recordings of which others stay for their history; None for all.
    """

    chain: Chain
    train: Recordings
    solve: Callable[[Whitening], Fit]
    linearised: Callable[[FloatArray], tuple[FloatArray, FloatArray]]
    prior: tuple[FloatArray, FloatArray] | None = None
    counts: BoolArray | None = None

    def effects(self, errors: DeclaredLoadErrors, values: FloatArray) -> tuple[LoadEffect, ...]:
        """What declared errors do to the readings at parameters (p,), nothing in rows that do not count."""
        found = errors.effects(self.chain, values, self.train)
        if self.counts is None:
            return found
        apart = self.counts[:, None, None]
        return tuple(replace(effect, moved=effect.moved * apart) for effect in found)


@dataclass(frozen=True)
class WeighedLoads:
    """Load errors in a fit.

    Attributes:
        estimator: how they count.
        effects: at the fitted parameters.
        weights: λ of every effect, in declared standard deviations; 0 for the `weighted` estimator.
        sizes: μ of every effect; 1 for the `weighted` estimator.
        estimated: the shared errors, as the recordings show them; 0 for the `weighted` estimator.
        deviations: standard deviations of these estimates, in declared ones, shape (d,).
        acting: those that act at targets as well.
        excess: K·(C(μ) − C(λ))·Kᵀ, what sizes beyond the weights add to the covariance of the parameters, shape (p, p).
        joined: what μ standard deviations of every error do to the parameters, and below these to the error of the
            estimates of `acting`.
    """

    estimator: Estimator
    effects: tuple[LoadEffect, ...]
    weights: FloatArray
    sizes: FloatArray
    estimated: EstimatedLoads
    deviations: FloatArray
    acting: LoadsAtTargets
    excess: FloatArray
    joined: Propagated

    def at_targets(self, fit: Fit) -> ActingLoads | None:
        """What acts at targets beside a fit whose covariance is that with which it predicts."""
        return self.acting.shown(self.estimated, fit)

    def acting_at(self, moved: FloatArray, *, weighed: bool) -> list[FloatArray]:
        """What every effect does at targets, (t, n, d) each, 0 where it does not act, per declared standard deviation.

        Args:
            moved: what those do that act, per unit of their parameters, shape (t, n, a).
            weighed: per standard deviation that the fit took instead.
        """
        sizes = self.weights if weighed else np.ones(len(self.effects))
        own = np.zeros((*moved.shape[:-1], len(self.estimated.mean)))
        own[..., self.acting.columns] = moved * self.acting.units
        parts = zip(self.effects, sizes.tolist(), shared_parts(self.effects), strict=True)
        nothing = np.zeros((*moved.shape[:-1], 1))
        return [
            size * (own[..., place] if effect.shared else np.tile(nothing, len(effect.deviation)))
            for effect, size, place in parts
        ]

    @property
    def record(self) -> dict[str, Any]:
        """What a document says of them."""
        entries = []
        parts = shared_parts(self.effects)
        for effect, weight, size, part in zip(self.effects, self.weights, self.sizes, parts, strict=True):
            entry: dict[str, Any] = {"source": effect.source, "unit": effect.unit, "shared": effect.shared}
            entry |= {"weight": effect.weight} if effect.weight else {}
            entry |= {"declared_std": effect.deviation.tolist(), "weight_taken": float(weight), "scale": float(size)}
            if effect.shared:
                entry["estimate"] = (self.estimated.mean[part] * effect.deviation).tolist()
                entry["std"] = (self.deviations[part] * effect.deviation).tolist()
            entries.append(entry)
        return {"estimator": self.estimator, "sources": entries}


def weighed(
    fitted: Fittable,
    noise: Whitening,
    errors: DeclaredLoadErrors,
    estimator: Estimator,
    weights: FloatArray | None = None,
) -> tuple[Fit, WeighedLoads]:
    """A fit with its load errors; its own covariance is that at the weights, to which `excess` is added.

    Args:
        fitted: what is fitted.
        noise: of the readings, loads taken as exact.
        errors: as they are declared.
        estimator: how they count.
        weights: λ = μ of every effect, or one of all; estimated if left out.
    """
    fit = fitted.solve(noise)
    if estimator == "weighted":
        effects = fitted.effects(errors, fit.values)
        return fit, _posterior(fitted, fit, noise, effects, (np.zeros(len(effects)), np.ones(len(effects))), estimator)
    for _ in range(_ROUNDS):
        effects = fitted.effects(errors, fit.values)
        if weights is None:
            scales = _scales(fitted, fit.values, noise, effects)
        else:
            scales = (np.broadcast_to(weights, len(effects)),) * 2
        before, fit = fit.values, fitted.solve(noise.weighing(load_columns(effects, scales[0])))
        moved = np.abs(fit.values - before) / np.sqrt(np.maximum(np.diag(fit.estimable.generalised), 1e-300))
        if moved.max(initial=0.0) < _SETTLED:
            break
    return fit, _posterior(fitted, fit, noise, effects, scales, estimator)


def conditional(fitted: Fittable, fit: Fit, noise: Whitening, loads: WeighedLoads) -> Fit:
    """The same fit with load errors among its parameters, by which levels of the noise are estimated.

    A variance of the noise is estimated by restricted maximum likelihood from the squares of r − S·θ − G·δ and the hat
    matrix of both, S and G (Henderson's mixed model equations; Searle, Casella and McCulloch, Variance Components,
    1992, section 7.3). Errors of single rows are terms as well.
    """
    columns = load_columns(loads.effects, loads.weights).as_shared.shared
    residuals, sensitivities = fitted.linearised(fit.values)
    whitened = as_matrix(noise.apply(columns))
    slopes, known = as_matrix(noise.apply(sensitivities)), np.ones(whitened.shape[1])
    model = _joint(fitted, fit.values, (slopes, whitened), known, noise.apply(residuals).ravel())
    left = (model.readings - model.columns @ model.estimate).reshape(residuals.shape)
    return replace(
        fit, residuals=left, sensitivities=model.columns.reshape(*residuals.shape, -1), estimable=model.estimable
    )


def of_parameters(known: Estimable, count: int) -> Estimable:
    """The first parameters of more."""
    return Estimable(known.generalised[:count, :count], known.directions[:count], known.resolution[:count])


def _joint(
    fitted: Fittable,
    values: FloatArray,
    columns: tuple[FloatArray, FloatArray],
    sizes: FloatArray,
    readings: FloatArray,
) -> Gaussian:
    """The parameters at values (p,) and errors of the loads with `sizes` (d,), by columns (M, p) and (M, d)."""
    mean, deviation = fitted.prior or (values, np.full(len(values), np.inf))
    away = np.where(np.isfinite(deviation), mean - values, 0.0)
    nothing = np.zeros(len(sizes))
    return Gaussian(np.hstack(columns), readings, np.append(deviation, sizes), np.append(away, nothing))


def _scales(
    fitted: Fittable, values: FloatArray, noise: Whitening, effects: tuple[LoadEffect, ...]
) -> tuple[FloatArray, FloatArray]:
    """λ and μ of every effect, by evidence and prior; effects of one source have one."""
    residuals, sensitivities = fitted.linearised(values)
    sources = list(dict.fromkeys(effect.source for effect in effects))
    index = np.array([sources.index(effect.source) for effect in effects])
    among = np.array([effect.shared for effect in effects])
    shared = [effect for effect in effects if effect.shared]
    own = any(not effect.shared for effect in effects)

    def pieces(scales: FloatArray) -> tuple[FloatArray, float]:
        """Sensitivities, columns of shared errors and readings, as small as they can be, and ln|C| of single rows."""
        columns = load_columns(effects, scales)
        whitening = noise.weighing(LoadColumns(columns.shared[..., :0], columns.own) if own else None)
        parts = [sensitivities, *(effect.moved for effect in shared), residuals[..., None]]
        whole: FloatArray = np.hstack([as_matrix(whitening.apply(part)) for part in parts])
        if len(whole) > whole.shape[1]:
            whole = np.asarray(np.linalg.qr(whole, mode="r"))
        return whole, whitening.log_determinant

    fixed = None if own else pieces(np.ones(len(effects)))

    def misfit(logs: FloatArray, density: float) -> float:
        scales = np.exp(logs[index])
        whole, volume = fixed or pieces(scales)
        sizes = np.repeat(scales[among], [effect.moved.shape[2] for effect in shared])
        columns = whole[:, : len(values)], whole[:, len(values) : -1]
        model = _joint(fitted, values, columns, sizes, whole[:, -1])
        # The density of λ is that of ln λ over λ.
        prior = 0.5 * float(logs @ logs) / SCALE_SPREAD**2 + density * float(logs.sum())
        return -model.log_evidence + 0.5 * volume + prior

    bounds = [(-_FARTHEST, _FARTHEST)] * len(sources)
    start, ends = np.zeros(len(sources)), []
    for density in (0.0, 1.0):
        found = minimize(misfit, start, (density,), method="L-BFGS-B", bounds=bounds, options={"ftol": 1e-10})
        start = np.asarray(found.x)
        ends.append(np.exp(start[index]))
    return ends[1], ends[0]


def _posterior(
    fitted: Fittable,
    fit: Fit,
    noise: Whitening,
    effects: tuple[LoadEffect, ...],
    scales: tuple[FloatArray, FloatArray],
    estimator: Estimator,
) -> WeighedLoads:
    """What the readings say of the shared errors, and what errors do to the parameters, for either estimator."""
    weights, sizes = scales
    whitening = noise.weighing(load_columns(effects, weights) if estimator == "generalised" else None)
    unit = load_columns(effects, np.ones(len(effects))).shared
    rows = noise.weighing(LoadColumns(unit[..., :0], load_columns(effects, sizes).own))
    shared = [np.full(e.moved.shape[2], size) for e, size in zip(effects, sizes, strict=True) if e.shared]
    spread = np.concatenate([np.empty(0), *shared])
    gain, errors = gain_of(fit, whitening), (noise.deviations, effects, sizes.tolist())
    propagated = Propagated.of(gain, *errors)
    excess = propagated.covariance((1.0 - (weights / sizes) ** 2).tolist())
    if estimator == "generalised":
        estimated = EstimatedLoads.of(unit, spread, rows, fitted.linearised(fit.values))
    else:
        moved = [each[0] for e, each in zip(effects, propagated.moved, strict=True) if e.shared]
        nothing = np.empty((len(fit.values), 0))
        estimated = EstimatedLoads.propagated(spread, np.hstack([nothing, *moved]), fitted.train.deflections.shape)
    known = fit.estimable.generalised + excess
    acting = LoadsAtTargets.of(fitted.chain.robot, fitted.train, effects, sizes)
    joint_gain, own = acting.joined(estimated, gain)
    return WeighedLoads(
        estimator=estimator,
        effects=effects,
        weights=weights,
        sizes=sizes,
        estimated=estimated,
        deviations=np.sqrt(np.diag(estimated.covariance(known))),
        acting=acting,
        excess=excess,
        joined=Propagated.of(joint_gain, *errors, own),
    )
