"""The variance of the attained pose when the whole experiment is done k times, everything set up anew.

The readings then say k times as much, and what is known beside them stays: priors, and errors of the load that all
copies share. With Λ = M + Λ_0, the information of the readings and of the rest, that of k copies is k·M + Λ_0.

By `generalised` least squares shared load errors are among the unknowns, with their prior in Λ_0: more readings
determine them better where the readings tell them from the parameters, and never where they do not. By `weighted` ones
they reach the estimate as S_0 + k·S, and those that every measurement has of its own as √k·N (`Information.repeated`).
"""

from collections.abc import Sequence
from dataclasses import dataclass

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
    """What the variances at t targets along n axes are made of.

    Attributes:
        readings: what those of one copy say, one set without batch dimensions.
        known: what is known beside them; None for nothing.
        rows: T of the parameters, shape (t, n, p).
        acting: T of the load errors of each source, 0 where they do not act at a target, (t, n, d) each.
        constant: variance that no reading changes (m², rad²), shape (t, n).
    """

    readings: Information
    known: Information | None
    rows: FloatArray
    acting: tuple[FloatArray, ...]
    constant: FloatArray

    def variances(self, times: FloatArray | float) -> FloatArray:
        """Variances (m², rad²) with k copies, k of any shape that goes with (t, n): of that shape; NaN where the
        readings do not determine an axis.
        """
        different, which = np.unique(times, return_inverse=True)
        several = self.readings.repeated(different)
        together = several if self.known is None else several.plus(self.known)
        noise, loads = together.budget(self.rows, self.acting)
        target, axis = np.indices(self.constant.shape)
        found: FloatArray = (noise + loads.sum(axis=-1))[which.reshape(np.shape(times)), target, axis] + self.constant
        return found


def planned_repetitions(
    assessment: Assessment, acting: tuple[FloatArray, ...], constant: FloatArray
) -> list[Repetition]:
    """Of the designs of an assessment, whose sources are `acting` at the targets, (t, n, d) each, which have `constant`
    variances (t, n) that no reading changes beside their own.
    """
    readings, known, rows = assessment.readings, assessment.before, assessment.targets.observation
    found = []
    for design in range(assessment.batch):
        own = known if known is None or known.root.ndim == 2 else known.part(design)
        found.append(Repetition(readings.part(design), own, rows, acting, constant))
    return found


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
        common = (at for effect, at in zip(effects, acting, strict=True) if effect.shared)
        acting = [np.concatenate([none_there, *common], axis=-1)]
    # What the fit knows of its parameters is 1 in units of the root; what the readings do not say of it, priors do.
    seen = as_matrix(fit.sensitivities) @ root / level
    beside, axes = np.linalg.eigh(np.eye(len(root.T)) - seen.T @ seen)
    prior = np.sqrt(np.maximum(beside, 0.0))[:, None] * axes.T
    estimated = 0 if loads is None else loads.shared.shape[-1]
    known = Information(np.pad(prior, ((estimated, 0), (estimated, 0))))
    readings = Information.of_measurements(rows, tuple(errors), tuple(shared), estimator=estimator)
    return Repetition(readings, known, sensitivities @ root, tuple(acting), constant)


def _root(known: Estimable) -> FloatArray:
    """B with P = B·Bᵀ of what is estimable, shape (p, r)."""
    scale = known.resolution
    values, vectors = np.linalg.eigh(known.generalised / np.outer(scale, scale))
    kept = values > RANK_TOLERANCE**2 * values.max(initial=0.0)
    found: FloatArray = scale[:, None] * vectors[:, kept] * np.sqrt(values[kept])
    return found
