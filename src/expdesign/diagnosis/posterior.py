"""The posterior over what may be there: where a law is, which physics an effect is, and averages where rows are few.

Explanations that exclude each other have probabilities in proportion to exp(log evidence/temperature), priors included:
machines and forms are never exact, and what separates two models is partly what both lack. What no library covers may
be behind everything.

- Where a law is: every component is given its chance in its place, the laws of all other components being kept.
- Which physics an effect is: models that were fitted in full, in the search or in its place afterwards, count with
  their penalised misfit, and so does the best law of every component and physics in its place: a name is a port and
  what it depends on, and its form may be another one than is declared. What held-out rows passed over is at most as
  likely as what they chose.
- What is predicted where little was measured: the likeliest explanation of a few recordings, often none, is not the
  best prediction. With it, M_0, linearised at its fit, and each effect k of the library with w ~ N(0, I) in its
  declared sizes beside it, the Bayes factor is their ratio of evidence (`state`). With prior odds (`averaged_odds`)
  that something is there, shared evenly among the kinds of physics and within a kind among its places, the mixture of
  all is predicted with (Hoeting et al., Statistical Science 14 (1999) 382).
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from scipy.linalg import cho_solve
from scipy.special import ndtr

from expdesign.arrays import FloatArray
from expdesign.chain.component import Component
from expdesign.chain.effect import Effect
from expdesign.chain.models.estimable import Estimable
from expdesign.chain.ports.law import Law
from expdesign.diagnosis.evidence.state import linearised
from expdesign.diagnosis.library import Candidate, physical_sizes
from expdesign.diagnosis.names import NamedModel, Names, hierarchical
from expdesign.diagnosis.options import OPTIONS
from expdesign.estimation.fit import Fit

_LARGEST = 500.0
"""Logarithm of a Bayes factor beyond which numbers end."""
_NOTHING = 1e-12
"""Probability that a parameter is on its side of zero below which the effect is not there."""


def probabilities(log_evidence: FloatArray, surest: float, inflation: float = 1.0) -> FloatArray:
    """Posterior probabilities of explanations that exclude each other, shape (n,).

    Args:
        log_evidence: of each, its prior included, shape (n,).
        surest: probability that one of them is right at all.
        inflation: by which residuals say less than as many independent rows would (`dispersion`).
    """
    weights = np.exp((log_evidence - log_evidence.max()) / (OPTIONS.temperature * inflation))
    return np.asarray(surest * weights / weights.sum())


@dataclass(frozen=True)
class Place:
    """A component where a law may be.

    Attributes:
        component: where.
        log_evidence: gain of log evidence by its laws together.
        probability: that the law is there.
        alike: whether the recordings do not tell it from the most probable one.
    """

    component: Component
    log_evidence: float
    probability: float
    alike: bool


def places(gains: Mapping[Component, float]) -> tuple[Place, ...]:
    """Components by probability, from the gain of log evidence by the laws of each."""
    names = sorted(gains, key=lambda name: -gains[name])
    evidence = np.array([gains[name] for name in names])
    alike = evidence[0] - evidence < max(OPTIONS.close, OPTIONS.remainder * float(evidence[0]))
    likely = probabilities(evidence, OPTIONS.surest_place)
    every = zip(names, evidence.tolist(), likely.tolist(), alike.tolist(), strict=True)
    return tuple(Place(*each) for each in every)


@dataclass(frozen=True)
class Standing:
    """How one effect of a model stands against what could be in its place.

    Attributes:
        probability: of this physics at this component.
        indistinguishable: other physics that would explain the recordings as well.
        rival: the best model with such other physics in its place, or None.
        elsewhere: other components at which this physics would explain the recordings as well.
        forms: models with the effect in another of its variants that explain the recordings as well.
    """

    probability: float
    indistinguishable: tuple[str, ...]
    rival: NamedModel | None
    elsewhere: tuple[str, ...] = ()
    forms: tuple[NamedModel, ...] = ()


def standing(
    model: NamedModel,
    index: int,
    others: Sequence[NamedModel],
    laws: Mapping[tuple[Component, str], float] = MappingProxyType({}),
    inflation: float = 1.0,
) -> Standing:
    """Standing of effect `index` of a model.

    Args:
        model: the chosen model.
        index: of the effect.
        others: the model without the effect, and models with something else in its place.
        laws: gains of log evidence by laws in its place, by component and physics.
        inflation: by which residuals say less than as many independent rows would (`dispersion`).
    """
    chosen, own = model.candidates[index].effect, set(model.keys)
    others = list({m.keys: m for m in others if m.keys != model.keys}.values())
    gaps = np.array([other.misfit - model.misfit for other in others])
    same, rivals = [True], dict[str, tuple[float, NamedModel]]()
    elsewhere, forms = list[tuple[float, str]](), list[NamedModel]()
    for gap, other in zip((gaps / inflation).tolist(), others, strict=True):
        extra = [effect for effect in other.effects if effect.key not in own]
        there = any(e.physics == chosen.physics and e.component == chosen.component for e in extra)
        same.append(there or _idle_elsewhere(model, chosen, other, extra))
        if len(extra) == 1 and extra[0].physics == chosen.physics and gap < OPTIONS.indistinguishable:
            if extra[0].slot == chosen.slot:
                forms.append(other)
            elif not same[-1]:
                elsewhere.append((gap, str(extra[0].component)))
        for physics in {e.physics for e in extra} - {chosen.physics}:
            if gap < min(rivals.get(physics, (OPTIONS.indistinguishable,))[0], OPTIONS.indistinguishable):
                rivals[physics] = gap, other
    gains = np.concatenate([[0.0], -0.5 * np.maximum(gaps, 0.0), np.minimum([*laws.values()], 0.0)])
    same += [(component, physics) == (chosen.component, chosen.physics) for component, physics in laws]
    likely = probabilities(gains, OPTIONS.surest, inflation)
    order = sorted(rivals, key=lambda physics: (rivals[physics][0], physics))
    alike = [p for (_, p), gain in laws.items() if -2.0 * gain / inflation < OPTIONS.indistinguishable]
    further = [physics for physics in alike if physics not in {chosen.physics, Law.physics}]
    return Standing(
        float(likely[same].sum()),
        tuple(dict.fromkeys([*order, *further])),
        rivals[order[0]][1] if order else None,
        tuple(dict.fromkeys(place for _, place in sorted(elsewhere))),
        tuple(forms),
    )


def _idle_elsewhere(model: NamedModel, chosen: Effect, other: NamedModel, extra: Sequence[Effect]) -> bool:
    """Whether another model has this physics with a size of its own at every part, and nothing to show at other parts.

    It includes the chosen effect, and what it adds takes no more from χ² than a parameter that is not there may.
    """
    return (
        model.fit.chi2 - other.fit.chi2 < OPTIONS.noticeable**2
        and len(extra) == 1
        and extra[0].physics == chosen.physics
        and extra[0].component.several
        and not chosen.component.several
        and sum(not p.shape for p in extra[0].parameters) >= len(model.fit.chain.robot.stiffness)
    )


@dataclass(frozen=True)
class _Beside:
    """One effect beside the likeliest model.

    Attributes:
        candidate, start: of the library, and the number of its start.
        odds: posterior, against the likeliest model.
        change: of the model's parameters and those of the effect that are no shapes, shape (p + d,).
        covariance: of them by what is not known of the effect, shape (p + d, p + d).
    """

    candidate: Candidate
    start: int
    odds: float
    change: FloatArray
    covariance: FloatArray


def averaged(names: Names, model: NamedModel) -> NamedModel:
    """The model with its parameters averaged over every single effect of the library beside it, where rows are few.

    It is as it is where rows are enough to tell, where they do not determine its own parameters, and where nothing
    beside it has any weight.

    Args:
        names: with the library and the rows.
        model: the likeliest one.
    """
    few = int(names.sample.counts.sum()) < OPTIONS.fewest_rows
    if not (few and model.fit.determined.all() and names.sample.readings > model.fit.rank):
        return model
    forms: dict[object, list[_Beside]] = {}  # of every part's physics
    for one in _beside(names, model):
        forms.setdefault(one.candidate.effect.slot, []).append(one)
    likeliest = [(sum(one.odds for one in own), max(own, key=lambda one: one.odds)) for own in forms.values()]
    least = OPTIONS.slight * (1.0 + sum(odds for odds, _ in likeliest))
    likeliest = sorted((pair for pair in likeliest if pair[0] >= least), key=lambda pair: -pair[0])
    if not likeliest:
        return model
    kept, weights = [one for _, one in likeliest], np.array([1.0, *(odds for odds, _ in likeliest)])
    weights /= weights.sum()
    shares = ", ".join(f"`{o.candidate.effect.key}` {w:.2g}" for o, w in zip(kept, weights[1:], strict=True))
    names.log.add("averaging", f"what may be there besides the likeliest model: {shares}")
    return replace(model, fit=_average(names, model, kept, weights))


def _beside(names: Names, model: NamedModel) -> Iterator[_Beside]:
    sample = names.sample
    noise = 1.0 if names.known_noise else max(model.fit.chi2 / max(sample.readings - model.fit.rank, 1), 1e-300)
    present = linearised(model.fit, sample)
    known = replace(present, readings=present.readings / np.sqrt(noise))
    sizes = physical_sizes(names.robot, sample, names.base.fit)
    kinds = len({candidate.effect.physics for candidate in names.library})
    for candidate in names.library:
        effect = candidate.effect
        taken = effect.slot in {e.slot for e in model.effects} or not hierarchical([*model.effects, effect])
        if candidate.idle or taken:
            continue
        free = [p for p in effect.parameters if not p.shape]
        for start, directions in enumerate(candidate.directions):
            own = directions.matrix()[sample.kept]
            deviations = np.array([sizes.of(effect.size(p), effect, p, own[:, i]) for i, p in enumerate(free)])
            grown = known.beside(own * deviations / np.sqrt(noise), 1.0)
            share, mean, covariance = _moments(*grown.posterior(0), one_sided=bool(candidate.one_sided.all()))
            odds = share * float(np.exp(min(grown.log_evidence - known.log_evidence, _LARGEST)))
            to_model = cho_solve((known.lower, True), known.base.T @ own)
            to_all = np.vstack([-to_model, np.eye(len(free))]) * deviations
            odds *= OPTIONS.averaged_odds / (kinds * candidate.places)
            yield _Beside(candidate, start, odds, to_all @ mean, to_all @ covariance @ to_all.T)


def _moments(mean: FloatArray, covariance: FloatArray, *, one_sided: bool) -> tuple[float, FloatArray, FloatArray]:
    """Mean and covariance of weights, or of one that cannot be negative and has twice the prior above zero.

    And by what the Bayes factor has to be multiplied for that.
    """
    if not (one_sided and len(mean) == 1):
        return 1.0, mean, covariance
    deviation = float(np.sqrt(covariance[0, 0]))
    at = float(mean[0]) / deviation
    share = float(ndtr(at))
    if share < _NOTHING:
        return 0.0, np.zeros(1), covariance
    hazard = float(np.exp(-0.5 * at**2)) / float(np.sqrt(2.0 * np.pi)) / share
    variance = covariance[0, 0] * max(1.0 - hazard * (hazard + at), 0.0)
    return 2.0 * share, mean + deviation * hazard, np.array([[variance]])


def _average(names: Names, model: NamedModel, kept: Sequence[_Beside], weights: FloatArray) -> Fit:
    """The chain with all of them, at the average of its parameters; `weights` of the model and of each, (1 + n,)."""
    fit = model.fit
    chain = names.sample.chain(names.robot, (*fit.chain.effects, *(one.candidate.effect for one in kept)))
    count, own = len(chain.parameters), len(fit.values)
    start = np.concatenate([fit.values, *(one.candidate.starts[one.start] for one in kept)])
    changes, covariances = np.zeros((1 + len(kept), count)), np.zeros((1 + len(kept), count, count))
    covariances[:, :own, :own] = fit.covariance
    for k, (one, part) in enumerate(zip(kept, chain.slices[len(fit.chain.effects) :], strict=True), start=1):
        effect = one.candidate.effect
        free = np.array([not p.shape for p in effect.parameters])
        into = np.append(np.arange(own), np.arange(part.start, part.stop)[free])
        start[into[own:]] = effect.neutral()[free]
        changes[k, into] = one.change
        covariances[k][np.ix_(into, into)] += one.covariance
    mean = weights @ changes
    values = np.clip(start + mean, *chain.bounds())
    spread = np.einsum("m,mi,mj->ij", weights, changes - mean, changes - mean)
    residuals, slopes = names.sample.residuals_with_sensitivities(chain, values)
    return replace(
        fit,
        chain=chain,
        values=values,
        estimable=Estimable.from_covariance(np.einsum("m,mij->ij", weights, covariances) + spread),
        residuals=residuals,
        sensitivities=slopes,
        chi2=float((residuals**2).sum()),
    )
