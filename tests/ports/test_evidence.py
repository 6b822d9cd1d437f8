"""The closed forms of evidence and left-out errors against dense linear algebra and refits."""

import numpy as np
import pytest

from expdesign.arrays import FloatArray
from expdesign.chain.ports.evidence import Present

GENERATOR = np.random.default_rng(3)
BASE = GENERATOR.standard_normal((40, 3))
LAW, OTHER = GENERATOR.standard_normal((40, 6)), GENERATOR.standard_normal((40, 4))
READINGS = GENERATOR.standard_normal(40) + LAW @ (1.5 * GENERATOR.standard_normal(6))


def present(*laws: tuple[FloatArray, float]) -> Present:
    return Present(BASE, np.zeros(3), READINGS, tuple(law for law, _ in laws), tuple(size for _, size in laws))


def restricted_likelihood(variance: FloatArray) -> float:
    """−½(yᵀPy + ln det V + ln det AᵀV⁻¹A), dense (Patterson and Thompson 1971)."""
    inverse = np.linalg.inv(variance)
    inner = BASE.T @ inverse @ BASE
    projector = inverse - inverse @ BASE @ np.linalg.solve(inner, BASE.T @ inverse)
    volume = np.linalg.slogdet(variance)[1] + np.linalg.slogdet(inner)[1]
    return float(-0.5 * (READINGS @ projector @ READINGS + volume))


def test_evidence_is_the_restricted_likelihood_of_a_gaussian_process() -> None:
    dense = [restricted_likelihood(np.eye(40) + s * LAW @ LAW.T + 0.7 * OTHER @ OTHER.T) for s in (0.1, 2.0)]
    closed = [present((LAW, s), (OTHER, 0.7)).log_evidence for s in (0.1, 2.0)]
    assert closed[1] - closed[0] == pytest.approx(dense[1] - dense[0], rel=1e-7)


def test_gain_is_the_largest_difference_of_evidence() -> None:
    before = present((OTHER, 0.7))
    gain, size = before.gain(LAW)
    differences = [
        present((OTHER, 0.7), (LAW, s)).log_evidence - before.log_evidence for s in np.geomspace(1e-3, 1e6, 2000)
    ]
    assert gain == pytest.approx(max(differences), abs=1e-2)
    assert present((OTHER, 0.7), (LAW, size)).log_evidence - before.log_evidence == pytest.approx(gain, abs=1e-6)


def test_refitted_sizes_leave_no_slope() -> None:
    best = present((LAW, 0.1), (OTHER, 0.5)).refitted()
    # The second law is not there: its size goes to the bound.
    assert best.variances[1] == pytest.approx(1e-3)
    for factor in (0.8, 1.25):
        other = best.with_variances((best.variances[0] * factor, best.variances[1]))
        assert other.log_evidence < best.log_evidence


def test_left_out_errors_are_those_of_refits() -> None:
    blocks = np.repeat(np.arange(8), 5)
    errors = present((LAW, 2.0), (OTHER, 0.7)).left_out(blocks)
    design = np.hstack([BASE, LAW, OTHER])
    precision = np.diag([0.0] * 3 + [1 / 2.0] * 6 + [1 / 0.7] * 4)
    for block in range(8):
        kept, left = blocks != block, blocks == block
        weights = np.linalg.solve(design[kept].T @ design[kept] + precision, design[kept].T @ READINGS[kept])
        np.testing.assert_allclose(errors[left], READINGS[left] - design[left] @ weights, rtol=1e-6, atol=1e-8)


def test_variances_of_left_out_errors_are_those_of_predictions_by_the_rest() -> None:
    """Noise and the posterior variance of a reading given all other blocks, with the base directions nearly free."""
    state = Present(BASE, np.full(3, 1e-6), READINGS, (LAW,), (0.8,))
    blocks = np.repeat(np.arange(8), 5)
    found = state.left_out_variances(blocks)
    design, precision = np.hstack([BASE, LAW]), np.concatenate([np.full(3, 1e-6), np.full(6, 1.0 / 0.8)])
    rest = blocks != 2
    covariance = np.linalg.inv(design[rest].T @ design[rest] + np.diag(precision))
    direct = 1.0 + np.einsum("ij,jk,ik->i", design[~rest], covariance, design[~rest])
    np.testing.assert_allclose(found[~rest], direct, rtol=1e-6)
