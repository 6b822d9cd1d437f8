"""DUIR: how measurement uncertainty reaches the position after compensation (theory.md 4.3)."""

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import Criterion


class Duir(Criterion):
    """√(Σ_t w_t Σ_i U_t,ii/tol_ti² / Σ_t w_t), or the largest target's: an RMS error in units of the tolerance."""

    name = "duir"
    title = "DUIR (measurement noise)"
    unit = "tolerances"
    root_mean_square = True

    def values(self, assessment: Assessment) -> FloatArray:
        return assessment.aggregated(assessment.weighted(assessment.noise_variance))
