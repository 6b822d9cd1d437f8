"""O5, Sun & Hollerbach 2008 (theory.md 7): related to A-optimality of the parameters."""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import Criterion


class O5(Criterion):
    """1 / Σ(1/μ_i)."""

    name = "o5"
    title = "O5 (harmonic singular values)"
    unit = "N/m"
    maximise = True

    def values(self, assessment: Assessment) -> FloatArray:
        with np.errstate(divide="ignore"):
            values: FloatArray = 1.0 / (1.0 / assessment.singular_values).sum(axis=1)
        return values
