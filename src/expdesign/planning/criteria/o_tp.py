"""O_TP, the test-pose criterion of Klimchik, Wu, Pashkevich, Caro & Furet (theory.md 7)."""

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import Criterion


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
