"""Forms are never exact: what physics does to a prediction is known to a share, however many the rows.

The covariance of a fit is that of a form which is the machine's own. The library's is another, fitted ever more closely
by more rows, and its predictions are wrong by a share √q of what the physics does to them. With v_k the deviation of
the parameters of effect k from none, of which it does A·v_k to the readings, predictions have the covariance

    C + q·Σ_k v_k·v_kᵀ,   p = Σ_k (A·v_k)²,

and q is what readings of blocks that were left out say (`LeftOut.widened`, with p in the place of the prior variance of
laws). Of a law every weight counts by itself, with its standard deviation beforehand; where the base model is refuted
and predicts all the same, so do its compliances.
"""

from dataclasses import replace

import numpy as np

from expdesign.arrays import FloatArray, as_matrix
from expdesign.chain.ports.law import Law
from expdesign.diagnosis.cross_validation import LeftOut, blocks_of, readings_of
from expdesign.diagnosis.names import NamedModel, Names
from expdesign.estimation.fit import Fit


def deviations_from_none(fit: Fit) -> FloatArray:
    """The v_k of a model as columns, shape (p, K): its effects, or its compliances where it has none."""
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


def inexactness(names: Names, model: NamedModel) -> float:
    """The share q of a model with named effects, or of the base model, that left-out readings ask for."""
    state, sample = names.state(model), names.sample
    scale, blocks = state.noise_variance, readings_of(blocks_of(sample), sample)
    done = as_matrix(model.fit.sensitivities)[sample.kept] @ deviations_from_none(model.fit)
    errors = state.left_out(blocks) / np.sqrt(scale)
    variances = state.left_out_variances(blocks) / scale
    return LeftOut(errors, errors, blocks).widened(variances, (done**2).sum(axis=1) / scale)[1]


def with_share(fit: Fit, share: float) -> Fit:
    """The fit with the covariance C + q·Σ_k v_k·v_kᵀ."""
    moved, known = deviations_from_none(fit), fit.estimable
    return fit.known_as(replace(known, generalised=known.generalised + share * (moved @ moved.T)))
