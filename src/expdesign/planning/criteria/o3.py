"""O3, Nahvi, Hollerbach & Hayward 1994 (theory.md 7): E-optimality of the parameters."""

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import Criterion
from expdesign.planning.criteria.extreme_singular_values import smallest_singular_value


class O3(Criterion):
    """μ_min."""

    name = "o3"
    title = "O3 (smallest singular value)"
    unit = "N/m"
    maximise = True

    def values(self, assessment: Assessment) -> FloatArray:
        return smallest_singular_value(assessment)
