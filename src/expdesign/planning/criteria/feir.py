"""FEIR: how errors of the applied load reach the position after compensation (theory.md 5.4)."""

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import Criterion


class Feir(Criterion):
    """√(Σ_t w_t Σ_i (ZΣ_FZᵀ)_t,ii/tol_ti² / Σ_t w_t), or the largest target's."""

    name = "feir"
    title = "FEIR (load errors)"
    unit = "tolerances"
    root_mean_square = True

    def values(self, assessment: Assessment) -> FloatArray:
        return assessment.aggregated(assessment.weighted(assessment.force_variance))
