"""Physics that the model leaves out and the recordings do not refute: what it may do at the targets, by probability.

Before the recordings, something is left out with the probability `PRESENT`, shared evenly among the
kinds of physics that the robot can have, and within a kind among the places and starts of its shapes. Its parameters x
are normal with their prior sizes (MEIR's, theory.md 21) or, where these are assumed, as likely with three times those.
The posterior of x beside the model's parameters, the Bayes factor against nothing left out, and the error of the
attained pose, which is what the model does not take up, are `Gaussian.joined` (Gelman et al., Bayesian Data Analysis,
3rd ed. 2013, 7.4 and 14.8). What physics with memory does is no multiple of its size: a little friction lags, much
holds a leg altogether. It is worked through the recordings at several sizes, each with the likelihood ratio
exp(dᵀQ·r − ½·dᵀQ·d), d being the change of the readings. The error is then a mixture, whose part beyond any tolerance
is the specific consumer's risk (JCGM 106:2012, 3.3.13). Errors of the loads that rows share stand beside the model's
parameters: what they take up of left-out physics is applied at targets where they act.
"""

from collections.abc import Sequence

import numpy as np

from expdesign.arrays import FloatArray, as_matrix
from expdesign.assurance.acceptance.decision import Basis, Decision, LeftOutRisk
from expdesign.assurance.acceptance.fitted import FittedModel, attained_at_targets, fitted_budget, places_tip
from expdesign.assurance.model_error.physics import Omitted, offsets
from expdesign.assurance.model_error.recorded import Shown
from expdesign.errors import InputError
from expdesign.estimation.gaussian import Gaussian
from expdesign.planning.problem import DesignProblem

PRESENT = 0.5
"""Probability, before its recordings are read, that physics which the base model lacks matters on a machine at all: as
likely as not.
"""
SCALES = (1.0, 3.0)
"""Of the prior size of a parameter that is assumed, each as likely as the other: what rests on no publication may be
half an order of magnitude larger.
"""
SIZES = (0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)
"""In prior ones, over which physics is integrated that is no multiple of its size."""


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

    Errors of the load that are declared are in the model.

    None as well where geometry is calibrated: sizes and motions of physics are those of deflections (MEIR's).
    """
    if places_tip(model.fit) or not problem.loaded.regressor.referenced:
        return None
    declared = () if model.loads is None else model.loads.acting.effects
    known = {effect.slot for effect in (*model.fit.chain.effects, *declared)}
    try:
        return Shown(problem, model.recordings, model.whitening, known=known)
    except InputError:  # the configuration leaves nothing over to consider
        return None


_Alternative = tuple[str, float, FloatArray, FloatArray]
"""What may be left out in words, ln of its prior odds times its Bayes factor, and mean (t·n,) and root (t·n, d) of what
it does to the attained poses."""


def left_out_risk(problem: DesignProblem, model: FittedModel, found: Shown) -> LeftOutRisk:
    """What may be left out of a model that its recordings do not refute.

    Args:
        problem: whose targets count.
        model: as its recordings determined it.
        found: what these show.
    """
    base = joint_model(problem, model)
    physics, meir, start = found.meir.physics, found.meir, offsets(found.meir.physics)
    rows, nothing = len(base.readings), np.zeros((meir.motions.shape[0] * meir.motions.shape[1], 1))
    apart = model.whitening.unshared
    odds = np.log(PRESENT / (1.0 - PRESENT))
    listed: list[_Alternative] = []
    for index, (entry, share) in enumerate(zip(physics, _shares(physics), strict=True)):
        columns, prior = slice(start[index], start[index + 1]), odds + np.log(share)
        kinds = (entry.effect.parameters[i] for i in entry.free)
        assumed = any(meir.assumptions.size(entry.effect, parameter).assumed for parameter in kinds)
        scales, phrase = SCALES if assumed else (1.0,), entry.effect.phrase
        if entry.step:
            shown, moved = found.at_sizes(index, SIZES)
            seen, there = apart(shown[:, :rows].T), moved.reshape(len(moved), -1).T
            likelihoods = seen.T @ base.projected - 0.5 * (seen * base.projection(seen)).sum(axis=0)
            logs = prior + np.log(_of_sizes(scales)) + likelihoods
            errors = base.unexplained(seen, there).T
            listed += [(phrase, float(log), mean, nothing) for log, mean in zip(logs, errors, strict=True)]
        else:
            shown = apart(found.directions[:rows, columns])
            shown = np.where(np.isfinite(shown).all(axis=0), shown, 0.0)
            moved = (meir.motions[..., columns] * meir.deviations[columns]).reshape(len(nothing), -1)
            prior -= np.log(len(scales))
            for scale in scales:
                log, mean, root = base.joined(shown, moved, scale)
                listed.append((phrase, prior + log, mean, root))
    weights = np.exp(np.array([0.0, *(log for _, log, _, _ in listed)]) - max(0.0, *(log for _, log, _, _ in listed)))
    shape = meir.motions.shape[:2]
    return LeftOutRisk(
        tuple(phrase for phrase, _, _, _ in listed),
        weights[1:] / weights.sum(),
        np.array([mean for _, _, mean, _ in listed]).reshape(-1, *shape),
        tuple(root.reshape(*shape, -1) for _, _, _, root in listed),
    )


def joint_model(problem: DesignProblem, model: FittedModel) -> Gaussian:
    """The fit as it was made, at the targets: the covariance that predictions have is larger, and would take up more
    than the fit.
    """
    fit, apart = model.fit, model.whitening.unshared
    columns = as_matrix(apart(fit.sensitivities))
    acting = None if model.loads is None else model.loads.at_targets(fit)
    attained = attained_at_targets(problem, fit, model.recordings, acting).sensitivities
    targets, there = np.split(attained, [columns.shape[1]], axis=-1)
    targets = targets.reshape(-1, columns.shape[1])
    knowledge = fit.chain.knowledge()
    spread = np.full(columns.shape[1], np.inf) if knowledge is None else knowledge[1]
    loads = model.whitening.loads
    if loads is not None and loads.shared.shape[-1] and model.loads is not None:
        weighed = as_matrix(model.whitening.without_shared.apply(loads.shared))
        at = [
            each.reshape(len(targets), -1)
            for effect, each in zip(model.loads.effects, model.loads.acting_at(there, weighed=True), strict=True)
            if effect.shared
        ]
        columns, targets = np.hstack([columns, weighed]), np.hstack([targets, *at])
        spread = np.append(spread, np.ones(weighed.shape[1]))
    return Gaussian(columns, apart(fit.residuals).ravel(), spread, at_targets=targets)


def _of_sizes(scales: Sequence[float]) -> FloatArray:
    """Probabilities of `SIZES` (K,) of a magnitude that is half-normal with one of some standard deviations."""
    nodes = np.array(SIZES)
    density = sum(np.exp(-0.5 * (nodes / scale) ** 2) / scale for scale in scales)
    weights: FloatArray = density * np.gradient(nodes)
    return weights / weights.sum()


def _shares(physics: tuple[Omitted, ...]) -> list[float]:
    """Share of the prior probability of every entry: evenly among kinds, then among places, then among starts."""
    kinds = {entry.effect.physics for entry in physics}
    places = {kind: {e.key for e in physics if e.effect.physics == kind} for kind in kinds}
    starts = [sum(e.key == entry.key for e in physics) for entry in physics]
    return [
        1.0 / len(kinds) / len(places[entry.effect.physics]) / count
        for entry, count in zip(physics, starts, strict=True)
    ]
