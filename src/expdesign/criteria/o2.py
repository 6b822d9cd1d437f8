"""O2, Driels & Pathre 1990 (theory.md 7): inverse condition number."""

from expdesign.arrays import FloatArray
from expdesign.criteria.assessment import Assessment
from expdesign.criteria.criterion import Criterion


class O2(Criterion):
    """μ_min / μ_max."""

    name = "o2"
    title = "O2 (inverse condition)"
    maximise = True

    def values(self, assessment: Assessment) -> FloatArray:
        values: FloatArray = 1.0 / assessment.condition
        return values
