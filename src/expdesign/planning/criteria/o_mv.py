"""O_MV: the test-pose criterion over a set of poses, by mean and by maximum (theory.md 7; the reading is assumed)."""

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import Criterion
from expdesign.planning.criteria.o_tp import translational_variance


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
