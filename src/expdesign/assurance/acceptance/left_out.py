"""Physics that the model leaves out and the recordings do not refute: what it may do at the targets, by probability.

Before the recordings, something is left out with the probability `LeftOutOptions.present`, shared evenly among the
kinds of physics that the robot can have, and within a kind among the places and starts of its shapes. Its parameters x
are normal with their prior sizes (MEIR's, theory.md 21) or, where these are assumed, as likely with three times those.
With S the whitened sensitivities of the model, P its covariance, r its residuals, B those of an effect, A and T what
model and effect do at the targets,

    x | r ~ N(C·Bᵀr, C),  C = (I + Bᵀ(B − S·P·SᵀB))⁻¹,  Bayes factor |C|^½·exp(½·rᵀB·C·Bᵀr)  against nothing left out

(Gelman et al., Bayesian Data Analysis, 3rd ed. 2013, 7.4 and 14.8), and the attained pose is off by (T − A·P·SᵀB)·x,
because the model takes up its share. What physics with memory does is no multiple of its size: a little friction lags,
much holds a leg altogether. It is worked through the recordings at several sizes, each with the likelihood ratio
exp(dᵀM·r − ½·dᵀM·d), M = I − S·P·Sᵀ, d being the change of the readings. The error is then a mixture, whose part beyond
any tolerance is the specific consumer's risk (JCGM 106:2012, 3.3.13).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import pinvh

from expdesign.arrays import FloatArray, as_matrix
from expdesign.assurance.acceptance.decision import Basis, Decision, LeftOutRisk
from expdesign.assurance.acceptance.fitted import FittedModel, attained_at_targets, fitted_budget, places_tip
from expdesign.assurance.model_error.left_out import Omitted, offsets
from expdesign.assurance.model_error.recorded import Shown
from expdesign.errors import InputError
from expdesign.estimation.fit import RANK_TOLERANCE, Fit
from expdesign.planning.problem import DesignProblem


@dataclass(frozen=True)
class LeftOutOptions:
    """What is thought of a machine before its recordings are read.

    Attributes:
        present: probability that physics which the base model lacks matters on it at all: as likely as not.
        scales: of the prior size of a parameter that is assumed, each as likely as the other: what rests on no
            publication may be half an order of magnitude larger.
        sizes: in prior ones, over which physics is integrated that is no multiple of its size.
    """

    present: float = 0.5
    scales: tuple[float, ...] = (1.0, 3.0)
    sizes: tuple[float, ...] = (0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)


def decided_by(
    problem: DesignProblem,
    model: FittedModel,
    shown: Shown | None,
    *,
    refuted: bool,
    remedy: str = "run `expdesign diagnose`",
) -> Decision:
    """The decision at the targets of a configuration by a model that recordings determined.

    Args:
        problem: with the targets.
        model: as its recordings determined it.
        shown: what these show of physics that it leaves out; None where nothing can be left out.
        refuted: whether they refute it, so that nothing is decided.
        remedy: what to do then.
    """
    budget = fitted_budget(problem, model)
    if refuted:
        return Decision(budget, Basis.REFUTED, remedy)
    return Decision(budget, left_out=None if shown is None else left_out_risk(problem, model, shown))


def left_out_by(problem: DesignProblem, model: FittedModel) -> Shown | None:
    """What recordings show of physics that may be left out of a model; None where nothing can be.

    None as well where geometry is calibrated: sizes and motions of physics are those of deflections (MEIR's).
    """
    if places_tip(model.fit) or not problem.loaded.regressor.referenced:
        return None
    known = {effect.slot for effect in model.fit.chain.effects}
    try:
        return Shown(problem, model.recordings, model.whitening, known=known)
    except InputError:  # the configuration leaves nothing over to consider
        return None


@dataclass(frozen=True)
class _Alternative:
    """One thing that may be left out: logarithm of its prior odds times its Bayes factor, and what it does there."""

    phrase: str
    log: float
    mean: FloatArray
    root: FloatArray


def left_out_risk(
    problem: DesignProblem, model: FittedModel, found: Shown, options: LeftOutOptions | None = None
) -> LeftOutRisk:
    """What may be left out of a model that its recordings do not refute.

    Args:
        problem: whose targets count.
        model: as its recordings determined it.
        found: what these show.
        options: what is thought beforehand.
    """
    rest, options = _Rest(problem, model), options or LeftOutOptions()
    physics, meir, start = found.meir.physics, found.meir, offsets(found.meir.physics)
    odds = np.log(options.present / (1.0 - options.present))
    listed: list[_Alternative] = []
    for index, (entry, share) in enumerate(zip(physics, _shares(physics), strict=True)):
        columns, prior = slice(start[index], start[index + 1]), odds + np.log(share)
        kinds = (entry.effect.parameters[i] for i in entry.free)
        assumed = any(meir.assumptions.size(entry.effect, parameter).assumed for parameter in kinds)
        scales = options.scales if assumed else (1.0,)
        if entry.step and options.sizes:
            weights = np.log(_of_sizes(options.sizes, scales))
            listed += rest.known(entry.effect.phrase, prior + weights, *found.at_sizes(index, options.sizes))
        else:
            shown, moved = found.directions[:, columns], meir.motions[..., columns] * meir.deviations[columns]
            prior -= np.log(len(scales))
            listed += [rest.unknown(entry.effect.phrase, prior, scale * shown, scale * moved) for scale in scales]
    logs = np.array([0.0, *(each.log for each in listed)])
    weights = np.exp(logs - logs.max())
    phrases, roots = tuple(each.phrase for each in listed), tuple(each.root for each in listed)
    return LeftOutRisk(phrases, weights[1:] / weights.sum(), np.array([each.mean for each in listed]), roots)


def _of_sizes(sizes: Sequence[float], scales: Sequence[float]) -> FloatArray:
    """Probabilities of sizes (K,) of a magnitude that is half-normal with one of some standard deviations."""
    nodes = np.array(sizes)
    density = sum(np.exp(-0.5 * (nodes / scale) ** 2) / scale for scale in scales)
    weights: FloatArray = density * np.gradient(nodes)
    return weights / weights.sum()


class _Rest:
    """What a model leaves of a change of its readings, and of the targets.

    Args:
        problem: whose targets count.
        model: as its recordings determined it.
    """

    def __init__(self, problem: DesignProblem, model: FittedModel) -> None:
        fit = model.fit
        self._sensitivities = as_matrix(fit.sensitivities)
        self._gain = _absorbed(fit)
        self._targets = attained_at_targets(problem, fit, model.recordings).sensitivities
        self._residuals = fit.residuals.ravel()

    def unknown(self, phrase: str, prior: float, shown: FloatArray, moved: FloatArray) -> _Alternative:
        """Physics with standard normal parameters: B (M, d) and T (t, n, d)."""
        shown = np.where(np.isfinite(shown).all(axis=0), shown, 0.0)[: self._residuals.size]
        taken = self._gain @ shown
        errors, remaining = moved - self._targets @ taken, shown - self._sensitivities @ taken
        covariance = np.linalg.inv(np.eye(shown.shape[1]) + shown.T @ remaining)
        projected = remaining.T @ self._residuals
        size = covariance @ projected
        log = prior + 0.5 * float(np.linalg.slogdet(covariance)[1] + projected @ size)
        values, vectors = np.linalg.eigh(0.5 * (covariance + covariance.T))
        return _Alternative(phrase, log, errors @ size, errors @ (vectors * np.sqrt(np.maximum(values, 0.0))))

    def known(self, phrase: str, priors: FloatArray, shown: FloatArray, moved: FloatArray) -> list[_Alternative]:
        """Physics at each of its sizes, of prior log odds (K,): changes (K, M) of readings and (K, t, n) of targets."""
        shown = shown[:, : self._residuals.size]
        taken = shown @ self._gain.T
        remaining = shown - taken @ self._sensitivities.T
        logs = priors + remaining @ self._residuals - 0.5 * (shown * remaining).sum(axis=1)
        means = moved - np.einsum("tnp,kp->ktn", self._targets, taken)
        nothing = np.zeros((*means.shape[1:], 1))
        return [_Alternative(phrase, float(log), mean, nothing) for log, mean in zip(logs, means, strict=True)]


def _absorbed(fit: Fit) -> FloatArray:
    """What a change of the readings does to the parameters of a fit, (SᵀS + Λ)⁻¹·Sᵀ, shape (p, M).

    Λ are precisions beforehand. The covariance that predictions have is larger, and would take up more than the fit.
    """
    slopes, knowledge = as_matrix(fit.sensitivities), fit.chain.knowledge()
    precision = np.zeros(slopes.shape[1]) if knowledge is None else knowledge[1] ** -2.0
    sizes = np.sqrt((slopes**2).sum(axis=0) + precision)
    scale = np.where(sizes > 0.0, 1.0 / np.where(sizes > 0.0, sizes, 1.0), 0.0)
    normal = (slopes.T @ slopes + np.diag(precision)) * np.outer(scale, scale)
    found: FloatArray = scale[:, None] * (pinvh(normal, rtol=RANK_TOLERANCE) @ (slopes * scale).T)
    return found


def _shares(physics: tuple[Omitted, ...]) -> list[float]:
    """Share of the prior probability of every entry: evenly among kinds, then among places, then among starts."""
    kinds = {entry.effect.physics for entry in physics}
    places = {kind: {e.key for e in physics if e.effect.physics == kind} for kind in kinds}
    starts = [sum(e.key == entry.key for e in physics) for entry in physics]
    return [
        1.0 / len(kinds) / len(places[entry.effect.physics]) / count
        for entry, count in zip(physics, starts, strict=True)
    ]
