"""Where little was measured predictions are the average over what may be there: against exact integrals."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from expdesign.arrays import FloatArray
from expdesign.diagnosis.evidence.state import Present
from expdesign.diagnosis.posterior import _moments

GENERATOR = np.random.default_rng(4)
PHI = GENERATOR.standard_normal((30, 3))
READINGS = PHI @ np.array([0.5, -1.0, 0.2]) + GENERATOR.standard_normal(30)


def weighed(law: FloatArray, readings: FloatArray, *, one_sided: bool = False) -> tuple[float, FloatArray, FloatArray]:
    """Bayes factor of a law of unit size, mean and covariance of its weights."""
    nothing = Present(np.zeros((30, 0)), np.zeros(0), readings)
    grown = nothing.beside(law, 1.0)
    share, mean, covariance = _moments(*grown.posterior(0), one_sided=one_sided)
    return share * float(np.exp(grown.log_evidence - nothing.log_evidence)), mean, covariance


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_cannot_be_negative_has_the_moments_of_a_half_normal(sign: float) -> None:
    column = 0.4 * PHI[:, :1]
    gram, slope = column.T @ column, sign * column.T @ READINGS

    def density(w: float) -> float:
        return float(2.0 * norm.pdf(w) * np.exp(slope[0] * w - 0.5 * gram[0, 0] * w**2))

    total, first, second = (quad(lambda w, k=k: w**k * density(w), 0.0, 12.0)[0] for k in range(3))
    factor, mean, covariance = weighed(column, sign * READINGS, one_sided=True)
    assert factor == pytest.approx(total, rel=1e-6)
    assert mean[0] == pytest.approx(first / total, rel=1e-6)
    assert covariance[0, 0] == pytest.approx(second / total - (first / total) ** 2, rel=1e-5)
