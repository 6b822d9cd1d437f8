"""O1, Borm & Menq 1989/91 (theory.md 7): D-optimality of the parameters."""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import Criterion


class O1(Criterion):
    """(μ_1 ⋯ μ_L)^{1/L} / √m over the singular values of the whitened observation matrix."""

    name = "o1"
    title = "O1 (D-optimality)"
    unit = "N/m"
    maximise = True

    def values(self, assessment: Assessment) -> FloatArray:
        with np.errstate(divide="ignore"):
            log_mean = np.log(assessment.singular_values).mean(axis=1)
        values: FloatArray = np.exp(log_mean) / np.sqrt(assessment.number)
        return values
