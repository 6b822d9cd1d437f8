"""O4, Nahvi & Hollerbach 1996 (theory.md 7): noise amplification index."""

from expdesign.arrays import FloatArray
from expdesign.criteria.assessment import Assessment
from expdesign.criteria.criterion import Criterion


class O4(Criterion):
    """μ_min² / μ_max."""

    name = "o4"
    title = "O4 (noise amplification)"
    unit = "N/m"
    maximise = True

    def values(self, assessment: Assessment) -> FloatArray:
        values: FloatArray = assessment.singular_values[:, -1] / assessment.condition
        return values
