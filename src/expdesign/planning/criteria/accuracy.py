"""The criteria of accuracy at the targets: DUIR, FEIR and their sum, and the test-pose criteria O_TP and O_MV.

DUIR is how measurement uncertainty reaches the position after compensation (theory.md 4.3), FEIR how errors of the
applied load do (5.4), `total` the RMS error to expect (6, physically scaled compromise). O_TP is of Klimchik, Wu,
Pashkevich, Caro & Furet (7); O_MV takes it over a set of poses, by mean and by maximum (the reading is assumed).
"""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import Criterion
from expdesign.planning.criteria.information import Information
from expdesign.planning.criteria.targets import GivenVariances, Targets, TargetVariances


class Duir(Criterion):
    """√(Σ_t w_t Σ_i U_t,ii/tol_ti² / Σ_t w_t), or the largest target's: an RMS error in units of the tolerance."""

    name = "duir"
    title = "DUIR (measurement noise)"
    unit = "tolerances"
    root_mean_square = True

    def values(self, assessment: Assessment) -> FloatArray:
        return assessment.aggregated(assessment.weighted(assessment.noise_variance))


class Feir(Criterion):
    """√(Σ_t w_t Σ_i (ZΣ_FZᵀ)_t,ii/tol_ti² / Σ_t w_t), or the largest target's."""

    name = "feir"
    title = "FEIR (load errors)"
    unit = "tolerances"
    root_mean_square = True

    def values(self, assessment: Assessment) -> FloatArray:
        return assessment.aggregated(assessment.weighted(assessment.force_variance))


class Total(Criterion):
    """√(DUIR² + FEIR²): independent errors add in squares; with `max`, the largest target's own sum."""

    name = "total"
    title = "total expected error"
    unit = "tolerances"
    root_mean_square = True

    def values(self, assessment: TargetVariances) -> FloatArray:
        variance = assessment.noise_variance + assessment.force_variance
        return assessment.aggregated(assessment.weighted(variance))


def expected_total(information: Information, targets: Targets) -> FloatArray:
    """√total² of a batch, in tolerances, shape (...); infinite where a target depends on parameters not determined."""
    matters = targets.importance > 0.0
    noise, force = (np.where(matters, part, 0.0) for part in information.variances(targets.observation))
    total = Total().values(GivenVariances(targets, noise, force))
    result: FloatArray = np.where(np.isnan(total), np.inf, total)
    return result


def translational_variance(assessment: Assessment) -> FloatArray:
    """Sum of the translational U_ii at every target (m²), shape (b, t)."""
    values: FloatArray = assessment.noise_variance[..., : assessment.targets.translations].sum(axis=-1)
    return values


class TestedPose(Criterion):
    """Sum of the translational U_ii at the first target; it knows neither tolerances nor load errors."""

    name = "o_tp"
    title = "O_TP (first target)"
    unit = "m²"

    def values(self, assessment: Assessment) -> FloatArray:
        return translational_variance(assessment)[:, 0]


class MeanVariance(Criterion):
    """Mean over the targets of the translational U_ii."""

    name = "o_mv"
    title = "O_MV (mean over targets)"
    unit = "m²"

    def values(self, assessment: Assessment) -> FloatArray:
        values: FloatArray = translational_variance(assessment).mean(axis=-1)
        return values


class MaximumVariance(Criterion):
    """Maximum over the targets of the translational U_ii."""

    name = "o_mv_max"
    title = "O_MV (largest target)"
    unit = "m²"

    def values(self, assessment: Assessment) -> FloatArray:
        return assessment.largest(translational_variance(assessment))
