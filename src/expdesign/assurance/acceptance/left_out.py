"""Physics that the model leaves out and the recordings do not refute: what it may do at the targets, by probability.

Before the recordings, something is left out with the probability `LeftOutOptions.present`, shared evenly among the
kinds of physics that the robot can have, and within a kind among the places and starts of its shapes. Its parameters x
are normal with their prior sizes (MEIR's, theory.md 21). With S the whitened sensitivities of the model, P its
covariance, r its residuals, B those of an effect, A and T what model and effect do at the targets,

    x | r ~ N(C·Bᵀr, C),  C = (I + Bᵀ(B − S·P·SᵀB))⁻¹,  Bayes factor |C|^½·exp(½·rᵀB·C·Bᵀr)  against nothing left out

(Gelman et al., Bayesian Data Analysis, 3rd ed. 2013, 7.4 and 14.8), and the attained pose is off by (T − A·P·SᵀB)·x,
because the model takes up its share. The error is then a mixture, whose part beyond any tolerance is the specific
consumer's risk (JCGM 106:2012, 3.3.13).
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray, as_matrix
from expdesign.assurance.acceptance.decision import Basis, Decision, LeftOutRisk
from expdesign.assurance.acceptance.fitted import FittedModel, fitted_budget, places_tip, target_sensitivities
from expdesign.assurance.model_error.left_out import Omitted, offsets
from expdesign.assurance.model_error.recorded import Shown, shown_by
from expdesign.errors import InputError
from expdesign.planning.problem import DesignProblem


@dataclass(frozen=True)
class LeftOutOptions:
    """What is thought of a machine before its recordings are read.

    Attributes:
        present: probability that physics which the base model lacks matters on it at all: as likely as not.
    """

    present: float = 0.5


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
        return shown_by(problem, model.recordings, model.whitening, known=known)
    except InputError:  # the configuration leaves nothing over to consider
        return None


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
    fit, meir = model.fit, found.meir
    shown = np.where(np.isfinite(found.directions).all(axis=0), found.directions, 0.0)[: fit.residuals.size]
    gain = fit.estimable.generalised / fit.inflation @ as_matrix(fit.sensitivities).T
    taken = gain @ shown
    missed = meir.motions * meir.deviations - target_sensitivities(problem, fit) @ taken
    remaining = shown - as_matrix(fit.sensitivities) @ taken
    return _posterior(meir.physics, shown, remaining, missed, fit.residuals.ravel(), options or LeftOutOptions())


def _posterior(
    physics: tuple[Omitted, ...],
    shown: FloatArray,
    remaining: FloatArray,
    missed: FloatArray,
    residuals: FloatArray,
    options: LeftOutOptions,
) -> LeftOutRisk:
    """The alternatives from B (M, D), what the model leaves of it (M, D), the misses (t, n, D) and r (M,)."""
    start, odds = offsets(physics), options.present / (1.0 - options.present)
    logs, means, roots = [0.0], [], []
    for index, share in enumerate(_shares(physics)):
        columns = slice(start[index], start[index + 1])
        errors, count = missed[..., columns], start[index + 1] - start[index]
        covariance = np.linalg.inv(np.eye(count) + shown[:, columns].T @ remaining[:, columns])
        projected = shown[:, columns].T @ residuals
        size = covariance @ projected
        logs.append(np.log(odds * share) + 0.5 * float(np.linalg.slogdet(covariance)[1] + projected @ size))
        means.append(errors @ size)
        values, vectors = np.linalg.eigh(0.5 * (covariance + covariance.T))
        roots.append(errors @ (vectors * np.sqrt(np.maximum(values, 0.0))))
    weights = np.exp(np.array(logs) - max(logs))
    phrases = tuple(entry.effect.phrase for entry in physics)
    return LeftOutRisk(phrases, weights[1:] / weights.sum(), np.array(means), tuple(roots))


def _shares(physics: tuple[Omitted, ...]) -> list[float]:
    """Share of the prior probability of every entry: evenly among kinds, then among places, then among starts."""
    kinds = {entry.effect.physics for entry in physics}
    places = {kind: {e.key for e in physics if e.effect.physics == kind} for kind in kinds}
    starts = [sum(e.key == entry.key for e in physics) for entry in physics]
    return [
        1.0 / len(kinds) / len(places[entry.effect.physics]) / count
        for entry, count in zip(physics, starts, strict=True)
    ]
