"""O2, Driels & Pathre 1990 (theory.md 7): inverse condition number."""

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import Criterion
from expdesign.planning.criteria.extreme_singular_values import after, largest_singular_value, smallest_singular_value


class O2(Criterion):
    """μ_min / μ_max."""

    name = "o2"
    title = "O2 (inverse condition)"
    maximise = True

    def values(self, assessment: Assessment) -> FloatArray:
        if assessment.place == 0:
            smallest_singular_value(assessment), largest_singular_value(assessment, after(assessment))
            return 1.0 / assessment.condition
        values: FloatArray = smallest_singular_value(assessment) / largest_singular_value(assessment, after(assessment))
        return values
