"""What is predicted where little was measured: the average over what may be there, by evidence.

A few recordings seldom tell which physics a machine hides, and the likeliest explanation of them, often none, is not
the best prediction. With the likeliest model M_0, linearised at its fit, and each effect k of the library beside it,

    M_k:  r = A·δ + Φ_k·w + e,   w ~ N(0, I),   Φ_k = D_k·diag(σ_k),

D_k being what its parameters do to the readings and σ_k their declared sizes, the Bayes factor of M_k against M_0 is

    B_k = exp(½·Σ_i [v_i²/(1 + λ_i) − ln(1 + λ_i)]),   Φ_kᵀPΦ_k = U·diag(λ)·Uᵀ,   v = Uᵀ·Φ_kᵀ·P·r,

P projecting on what M_0 cannot do. With prior odds (`averaged_odds`) that something is there beside it, shared evenly
among the kinds of physics and within a kind among its places, the posterior weights ω_k average parameters and add what
the models differ by to their covariance (Hoeting et al., Statistical Science 14 (1999) 382):

    θ̄ = Σ ω_k·θ_k,   C̄ = Σ ω_k·(C_k + (θ_k − θ̄)(θ_k − θ̄)ᵀ).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import norm

from expdesign.arrays import FloatArray, as_matrix
from expdesign.chain.sizes import PhysicalSizes
from expdesign.diagnosis.laws import base_alone
from expdesign.diagnosis.library import Candidate
from expdesign.diagnosis.names import NamedModel, Names, hierarchical
from expdesign.diagnosis.options import OPTIONS
from expdesign.estimation.fit import Fit
from expdesign.mechanics.elastostatics.maps import actuator_forces

_LARGEST = 500.0
"""Logarithm of a Bayes factor beyond which numbers end."""
_NOTHING = 1e-12
"""Probability that a parameter is on its side of zero below which the effect is not there."""


@dataclass(frozen=True)
class _Term:
    """One effect beside the likeliest model.

    Attributes:
        candidate: of the library.
        start: number of its start.
        weight: posterior odds against the likeliest model.
        values, covariance: posterior of its parameters that are no shapes, shapes (d,) and (d, d).
        gain: change of the model's parameters per parameter of the effect, shape (p, d).
    """

    candidate: Candidate
    start: int
    weight: float
    values: FloatArray
    covariance: FloatArray
    gain: FloatArray


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
    terms = _terms(names, model)
    kept = _kept(model, terms)
    if not kept:
        return model
    shares = ", ".join(f"`{term.candidate.effect.key}` {term.weight:.2g}" for term in kept)
    names.log.add_text("averaging", f"what may be there beside the likeliest model: {shares}")
    return replace(model, fit=_average(names, model, kept))


def _terms(names: Names, model: NamedModel) -> list[_Term]:
    sample = names.sample.restricted(~model.outliers)
    noise = 1.0 if names.known_noise else max(model.fit.chi2 / max(sample.readings - model.fit.rank, 1), 1e-300)
    present = base_alone(model.fit, sample)
    known = replace(present, readings=present.readings / np.sqrt(noise))
    # C·Aᵀ: what a change of the readings does to the parameters of the model.
    inverse = np.linalg.inv(present.lower)
    to_parameters = inverse.T @ inverse @ present.base.T
    sizes = _sizes(names)
    kinds = len({candidate.effect.physics for candidate in names.library})
    terms = []
    for candidate in names.library:
        effect = candidate.effect
        if candidate.idle or effect.slot in {e.slot for e in model.effects}:
            continue
        if not hierarchical([*model.effects, effect]):
            continue
        free = [p for p in effect.parameters if not p.shape]
        for start, directions in enumerate(candidate.directions):
            own = directions[sample.kept]
            deviations = np.array([sizes.of(effect.size(p), effect, p, own[:, i]) for i, p in enumerate(free)])
            grown = known.beside(own * deviations / np.sqrt(noise), 1.0)
            gain = min(grown.log_evidence - known.log_evidence, _LARGEST)
            share, mean, covariance = _posterior(*grown.posterior(0), one_sided=bool(candidate.one_sided.all()))
            odds = share * float(np.exp(gain))
            terms.append(
                _Term(
                    candidate, start, OPTIONS.averaged_odds * odds / (kinds * candidate.places), deviations * mean,
                    covariance * np.outer(deviations, deviations), -to_parameters @ own,
                )
            )  # fmt: skip
    return terms


def _sizes(names: Names) -> PhysicalSizes:
    """At the recorded poses and loads."""
    robot, recordings = names.robot, names.sample.recordings
    jacobians = robot.jacobians(recordings.configurations)
    forces = actuator_forces(jacobians, recordings.wrenches)
    compliance = np.einsum("nij,j,nij->ni", jacobians.pose, robot.compliance, jacobians.pose).mean(axis=0)
    springs = as_matrix(names.base.fit.sensitivities)[:, : len(robot.stiffness)]
    return PhysicalSizes(robot, forces, compliance, springs[names.sample.kept])


def _posterior(mean: FloatArray, covariance: FloatArray, *, one_sided: bool) -> tuple[float, FloatArray, FloatArray]:
    """Mean and covariance of weights, or of one that cannot be negative and has twice the prior above zero.

    And by what the Bayes factor has to be multiplied for that.
    """
    if not (one_sided and len(mean) == 1):
        return 1.0, mean, covariance
    deviation = float(np.sqrt(covariance[0, 0]))
    at = float(mean[0]) / deviation
    share = float(norm.cdf(at))
    if share < _NOTHING:
        return 0.0, np.zeros(1), covariance
    hazard = float(norm.pdf(at)) / share
    variance = covariance[0, 0] * max(1.0 - hazard * (hazard + at), 0.0)
    return 2.0 * share, mean + deviation * hazard, np.array([[variance]])


def _kept(model: NamedModel, terms: list[_Term]) -> list[_Term]:
    """Terms with weights that add up to one with that of the model; of every part's physics the likeliest."""
    total = 1.0 + sum(term.weight for term in terms)
    best: dict[object, _Term] = {}
    for term in terms:
        slot = term.candidate.effect.slot
        weight = term.weight + (best[slot].weight if slot in best else 0.0)
        likelier = slot not in best or term.weight > best[slot].weight
        best[slot] = replace(term if likelier else best[slot], weight=weight)
    chosen = sorted(best.values(), key=lambda term: -term.weight)
    chosen = [term for term in chosen if term.weight >= OPTIONS.slight * total]
    rest = 1.0 + sum(term.weight for term in chosen)
    return [replace(term, weight=term.weight / rest) for term in chosen]


def _average(names: Names, model: NamedModel, terms: list[_Term]) -> Fit:
    """The chain with all of them, at the averages of their parameters."""
    fit = model.fit
    chain = names.sample.chain(names.robot, (*fit.chain.effects, *(t.candidate.effect for t in terms)))
    count, own = len(chain.parameters), len(fit.values)
    start = np.concatenate([fit.values, *(t.candidate.starts[t.start] for t in terms)])
    columns = []
    for term, part in zip(terms, chain.slices[len(fit.chain.effects) :], strict=True):
        free = np.array([not p.shape for p in term.candidate.effect.parameters])
        columns.append(np.arange(part.start, part.stop)[free])
        start[columns[-1]] = term.candidate.effect.neutral()[free]
    changes, covariances = [np.zeros(count)], [np.zeros((count, count))]
    covariances[0][:own, :own] = fit.covariance
    for term, into in zip(terms, columns, strict=True):
        to_all = np.zeros((count, len(into)))
        to_all[:own] = term.gain
        to_all[into, np.arange(len(into))] = 1.0
        changes.append(to_all @ term.values)
        covariances.append(covariances[0] + to_all @ term.covariance @ to_all.T)
    weights = np.array([1.0 - sum(term.weight for term in terms), *(term.weight for term in terms)])
    mean = weights @ np.array(changes)
    away = np.array(changes) - mean
    covariance = np.einsum("k,kij->ij", weights, np.array(covariances)) + (away.T * weights) @ away
    values = np.clip(start + mean, *chain.bounds())
    sample = names.sample.restricted(~model.outliers)
    residuals, slopes = sample.residuals_with_sensitivities(chain, values)
    return Fit(
        chain=chain,
        values=values,
        covariance=covariance,
        determined=np.ones(count, dtype=bool),
        residuals=residuals,
        sensitivities=slopes,
        chi2=float((residuals**2).sum()),
        dof=fit.dof,
        rank=fit.rank,
        inflation=fit.inflation,
    )
