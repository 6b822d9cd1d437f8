"""O4, Nahvi & Hollerbach 1996 (theory.md 7): noise amplification index."""

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import Criterion
from expdesign.planning.criteria.extreme_singular_values import after, largest_singular_value, smallest_singular_value


class O4(Criterion):
    """μ_min² / μ_max."""

    name = "o4"
    title = "O4 (noise amplification)"
    unit = "N/m"
    maximise = True

    def values(self, assessment: Assessment) -> FloatArray:
        if assessment.place == 0:
            smallest_singular_value(assessment), largest_singular_value(assessment, after(assessment))
            return assessment.singular_values[:, -1] / assessment.condition
        values: FloatArray = smallest_singular_value(assessment) ** 2 / largest_singular_value(
            assessment, after(assessment)
        )
        return values
