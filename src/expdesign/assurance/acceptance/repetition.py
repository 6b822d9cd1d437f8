"""The variance of the attained pose when the whole experiment is done k times, everything set up anew.

The readings then say k times as much, and what is known beside them stays: priors, and errors of the load that all
copies share. With Λ = M + Λ_0, the information of the readings and of the rest, that of k copies is k·M + Λ_0. One
decomposition gives it for every k: with Λ = RᵀR and R⁻ᵀ·M·R⁻¹ = V·diag(μ)·Vᵀ

    (k·M + Λ_0)⁻¹ = R⁻¹·V·diag(h)·Vᵀ·R⁻ᵀ,   h = 1/(1 + (k − 1)·μ).

By `generalised` least squares shared load errors are among the unknowns, with their prior in Λ_0: more readings
determine them better where the readings tell them from the parameters (μ > 0), and never where they do not (μ = 0).
By `weighted` ones they reach the estimate as S_0 + k·S, and those that every measurement has of its own as √k·N. What
acts at the targets as well stands in T with the errors that are estimated, and is taken off the others (`budget`).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from expdesign.arrays import FloatArray, as_matrix
from expdesign.chain.models.estimable import Estimable
from expdesign.estimation.fit import Fit
from expdesign.estimation.load_errors import Estimator, LoadEffect
from expdesign.estimation.whitening import Whitening
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.information import RANK_TOLERANCE, Information


@dataclass(frozen=True)
class Repetition:
    """What the variances at t targets along n axes are made of, by q directions of the unknowns.

    Attributes:
        gain: T·R⁻¹·V, shape (t, n, q); NaN where the readings do not determine an axis.
        share: μ, the part of what is known along each direction that the readings say, shape (q,).
        known: what shared load errors do by what is known beside the readings, per standard deviation, shape (q, d).
        shared: by the readings of one copy, shape (q, d).
        own: what the load errors do that each measurement has of its own, shape (q, e).
        acting: what the shared load errors that are not estimated do at the targets themselves, shape (t, n, d).
        constant: variance that no reading changes (m², rad²), shape (t, n).
    """

    gain: FloatArray
    share: FloatArray
    known: FloatArray
    shared: FloatArray
    own: FloatArray
    acting: FloatArray
    constant: FloatArray

    @classmethod
    def of(
        cls,
        readings: Information,
        information: Information,
        targets: tuple[FloatArray, Sequence[FloatArray]],
        constant: FloatArray,
    ) -> "Repetition":
        """Of one copy of an experiment.

        Args:
            readings: what its readings say, one set without batch dimensions.
            information: the same with what is known beside them, the prior of load errors that are estimated included.
            targets: rows of the parameters, shape (t, n, p), and of the load errors of each source, 0 where they do not
                act there, (t, n, d) each.
            constant: variance that no reading changes (m², rad²), shape (t, n).
        """
        rows, acting = targets
        inverse = information.whole_inverse
        left, values, turned = np.linalg.svd(readings.root @ inverse)
        directions = inverse @ turned.T
        none_there: FloatArray = np.zeros((*rows.shape[:-1], 0))
        estimated = [at for at, width in zip(acting, information.estimated, strict=True) if width]
        gain = np.concatenate([none_there, *estimated, rows], axis=-1) @ directions
        gain[~information.estimable(rows)] = np.nan
        nothing: FloatArray = np.zeros((len(values), 0))
        known, shared, own, there = [nothing], [nothing], [nothing], [none_there]
        # The covariance of generalised least squares holds them already.
        propagated = readings.shared if information.estimator == "weighted" else ()
        for here, every, common, at in zip(readings.errors, information.errors, propagated, acting, strict=False):
            seen, reach = values[:, None] * (left.T @ here), directions.T @ (information.root.T @ every)
            if common:  # what the readings do not give of it, the rest does
                known.append(reach - seen)
                shared.append(seen)
                there.append(at)
                continue
            own.append(seen)
            before = reach[:, : reach.shape[1] - seen.shape[1]]  # of measurements that stand before these
            known.append(before)
            shared.append(np.zeros(before.shape))
            there.append(np.zeros((*rows.shape[:-1], before.shape[1])))
        return cls(
            gain,
            np.minimum(values**2, 1.0),
            known=np.concatenate(known, axis=1),
            shared=np.concatenate(shared, axis=1),
            own=np.concatenate(own, axis=1),
            acting=np.concatenate(there, axis=-1),
            constant=constant,
        )

    def variances(self, times: FloatArray | float) -> FloatArray:
        """Variances (m², rad²) with k copies, k of any shape that goes with (t, n): of that shape; NaN as in `gain`."""
        k = np.broadcast_to(times, np.broadcast_shapes(np.shape(times), self.constant.shape))
        weighed = self.gain / (1.0 + (k[..., None] - 1.0) * self.share)
        moved = weighed @ self.known + k[..., None] * (weighed @ self.shared) - self.acting
        own = k * ((weighed @ self.own) ** 2).sum(axis=-1)
        found: FloatArray = (weighed * self.gain).sum(axis=-1) + (moved**2).sum(axis=-1) + own + self.constant
        return found


def planned_repetitions(assessment: Assessment, acting: Sequence[FloatArray], constant: FloatArray) -> list[Repetition]:
    """Of the designs of an assessment, whose sources are `acting` at the targets, (t, n, d) each, which have `constant`
    variances (t, n) that no reading changes beside their own.
    """
    readings, information, rows = assessment.readings, assessment.information, assessment.targets.observation
    return [
        Repetition.of(readings.part(design), information.part(design), (rows, acting), constant)
        for design in range(assessment.batch)
    ]


def fitted_repetition(
    fit: Fit,
    whitening: Whitening,
    effects: Sequence[LoadEffect],
    targets: tuple[FloatArray, Sequence[FloatArray]],
    constant: FloatArray,
) -> Repetition:
    """Of recordings that a fit was made of.

    Args:
        fit: of the recorded rows.
        whitening: of these rows, by the load errors too where the fit weighs them.
        effects: load errors, which the fit only propagates where its whitening has none.
        targets: sensitivities of the attained pose to the parameters, shape (t, n, p), and to what the fit takes for a
            standard deviation of each effect, 0 where it does not act there, (t, n, d) each.
        constant: variance that no reading changes (m², rad²), shape (t, n).
    """
    loads, (sensitivities, acting) = whitening.loads, targets
    estimator: Estimator = "weighted" if loads is None else "generalised"
    alone = whitening.without_shared
    root, level = _root(fit.estimable), np.sqrt(fit.inflation)
    rows = whitening.unshared(fit.sensitivities) @ root / level
    if loads is None:
        errors, shared = [alone.apply(effect.moved) for effect in effects], [effect.shared for effect in effects]
    else:
        errors, shared = [alone.apply(loads.shared)], [True]
        none_there: FloatArray = np.zeros((*sensitivities.shape[:-1], 0))
        acting = [
            np.concatenate([none_there, *(at for e, at in zip(effects, acting, strict=True) if e.shared)], axis=-1)
        ]
    # What the fit knows of its parameters is 1 in units of the root; what the readings do not say of it, priors do.
    seen = as_matrix(fit.sensitivities) @ root / level
    beside, axes = np.linalg.eigh(np.eye(len(root.T)) - seen.T @ seen)
    prior = np.sqrt(np.maximum(beside, 0.0))[:, None] * axes.T
    estimated = 0 if loads is None else loads.shared.shape[-1]
    known = Information(np.pad(prior, ((estimated, 0), (estimated, 0))))
    of = partial(Information.of_measurements, rows, tuple(errors), tuple(shared), estimator=estimator)
    return Repetition.of(of(), of(known=known, closed=True), (sensitivities @ root, acting), constant)


def _root(known: Estimable) -> FloatArray:
    """B with P = B·Bᵀ of what is estimable, shape (p, r)."""
    scale = known.resolution
    values, vectors = np.linalg.eigh(known.generalised / np.outer(scale, scale))
    kept = values > RANK_TOLERANCE**2 * values.max(initial=0.0)
    found: FloatArray = scale[:, None] * vectors[:, kept] * np.sqrt(values[kept])
    return found
