"""Total: the RMS error to expect after compensation (theory.md 6, physically scaled compromise)."""

from expdesign.arrays import FloatArray
from expdesign.criteria.assessment import Assessment
from expdesign.criteria.criterion import Criterion


class Total(Criterion):
    """√(DUIR² + FEIR²): independent errors add in squares; with `max`, the largest target's own sum."""

    name = "total"
    title = "total expected error"
    unit = "tolerances"
    root_mean_square = True

    def values(self, assessment: Assessment) -> FloatArray:
        variance = assessment.noise_variance + assessment.force_variance
        return assessment.aggregated(assessment.weighted(variance))
