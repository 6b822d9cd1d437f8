"""Total: the RMS error to expect after compensation (theory.md 6, physically scaled compromise)."""

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.criterion import Criterion
from expdesign.planning.criteria.target_variances import TargetVariances


class Total(Criterion):
    """√(DUIR² + FEIR²): independent errors add in squares; with `max`, the largest target's own sum."""

    name = "total"
    title = "total expected error"
    unit = "tolerances"
    root_mean_square = True

    def values(self, assessment: TargetVariances) -> FloatArray:
        variance = assessment.noise_variance + assessment.force_variance
        return assessment.aggregated(assessment.weighted(variance))
