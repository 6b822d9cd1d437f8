"""The closed forms of evidence and left-out errors against dense linear algebra and refits."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from expdesign.arrays import FloatArray
from expdesign.diagnosis.evidence.state import Present

GENERATOR = np.random.default_rng(3)
BASE = GENERATOR.standard_normal((40, 3))
LAW, OTHER = GENERATOR.standard_normal((40, 6)), GENERATOR.standard_normal((40, 4))
READINGS = GENERATOR.standard_normal(40) + LAW @ (1.5 * GENERATOR.standard_normal(6))


def present(*laws: tuple[FloatArray, float]) -> Present:
    return Present(BASE, np.zeros(3), READINGS, tuple(law for law, _ in laws), tuple(size for _, size in laws))


def unknown(*laws: tuple[FloatArray, float], scale: float = 1.0) -> Present:
    return replace(present(*laws), readings=scale * READINGS, known_noise=False)


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


@pytest.mark.parametrize("made", [present, unknown], ids=["noise known", "noise not known"])
def test_gain_is_the_largest_difference_of_evidence(made: Callable[..., Present]) -> None:
    before = made((OTHER, 0.7))
    gain, size = before.gain(LAW)
    sizes = np.geomspace(1e-3, 1e6, 2000)
    differences = [made((OTHER, 0.7), (LAW, s)).log_evidence - before.log_evidence for s in sizes]
    assert gain == pytest.approx(max(differences), abs=1e-2)
    assert made((OTHER, 0.7), (LAW, size)).log_evidence - before.log_evidence == pytest.approx(gain, abs=1e-6)


def test_refitted_sizes_leave_no_slope() -> None:
    best = present((LAW, 0.1), (OTHER, 0.5)).refitted()
    # The second law is not there: its size goes to the bound.
    assert best.variances[1] == pytest.approx(1e-3)
    for factor in (0.8, 1.25):
        other = best.with_variances((best.variances[0] * factor, best.variances[1]))
        assert other.log_evidence < best.log_evidence


def test_shares_of_causes_that_stand_in_for_each_other_add_up() -> None:
    """Without either of two laws that are nearly alike, the other explains all the same; half of it is each one's."""
    alike = LAW + 1e-2 * GENERATOR.standard_normal(LAW.shape)
    state = present((LAW, 2.0), (alike, 2.0), (OTHER, 0.7))
    inverse = np.linalg.inv(np.eye(40) + 2.0 * LAW @ LAW.T + 2.0 * alike @ alike.T + 0.7 * OTHER @ OTHER.T)
    inverse -= inverse @ BASE @ np.linalg.solve(BASE.T @ inverse @ BASE, BASE.T @ inverse)
    projector = np.eye(40) - BASE @ np.linalg.pinv(BASE)
    explained = READINGS @ (projector - inverse) @ READINGS
    taken = [READINGS @ projector @ law @ (s * law.T @ inverse @ READINGS) for law, s in ((LAW, 2.0), (OTHER, 0.7))]
    np.testing.assert_allclose(state.shares[[0, 2]], np.array(taken) / explained, rtol=1e-6)
    assert state.shares.sum() == pytest.approx(1.0)
    assert min(state.shares[:2]) > 0.35
    assert state.without(0).scatter - state.scatter < 0.03 * explained


def test_a_law_against_another_has_a_negative_share() -> None:
    """What one takes too far the other takes back: 3 − 2 = 1 along one direction."""
    along, across = np.eye(40)[:, :1], np.eye(40)[:, 1:2]
    readings = np.zeros(40)
    readings[:2] = 10.0, -20.0
    state = Present(np.zeros((40, 0)), np.zeros(0), readings, (along + across, across), (1e3, 1e3))
    assert state.shares[0] == pytest.approx(-0.2, abs=0.01)
    assert state.shares[1] == pytest.approx(1.2, abs=0.01)


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


def test_noise_that_is_not_known_is_where_the_dense_likelihood_is_largest() -> None:
    def dense(noise: float, size: float) -> float:
        variance = noise * (np.eye(40) + size * LAW @ LAW.T)
        return restricted_likelihood(variance)

    grid = np.geomspace(0.1, 30.0, 2000)
    best = [max(dense(noise, size) for noise in grid) for size in (0.1, 2.0)]
    closed = [unknown((LAW, size)).log_evidence for size in (0.1, 2.0)]
    assert closed[1] - closed[0] == pytest.approx(best[1] - best[0], abs=1e-4)
    at = grid[np.argmax([dense(noise, 2.0) for noise in grid])]
    assert unknown((LAW, 2.0)).noise_variance == pytest.approx(at, rel=5e-3)


def test_without_known_noise_the_unit_of_the_readings_does_not_matter() -> None:
    one, large = (unknown((LAW, 0.3), (OTHER, 0.7), scale=scale).refitted() for scale in (1.0, 50.0))
    np.testing.assert_allclose(large.variances, one.variances, rtol=1e-3)
    assert large.noise_variance == pytest.approx(2500.0 * one.noise_variance, rel=1e-3)
    gains = [unknown((OTHER, 0.7), scale=scale).gain(LAW) for scale in (1.0, 50.0)]
    np.testing.assert_allclose(gains[1], gains[0], rtol=1e-9)


def test_refitted_sizes_beside_unknown_noise_leave_no_slope() -> None:
    best = unknown((LAW, 0.1)).refitted()
    for factor in (0.8, 1.25):
        assert best.with_variances((best.variances[0] * factor,)).log_evidence < best.log_evidence


def test_what_laws_do_and_how_many_weights_are_determined() -> None:
    """With a law so wide that its prior says nothing all its weights are determined, and parts add up to the whole."""
    state = present((LAW, 1e6), (OTHER, 1e-3))
    assert state.determined(0) == pytest.approx(6.0, abs=1e-3)
    assert state.determined(1) < 0.3
    parts = state.base @ state.weights[:3] + state.moved(0) + state.moved(1)
    np.testing.assert_allclose(parts, READINGS - state.projected, atol=1e-6)


@pytest.mark.parametrize("length", [5, 20])
def test_left_out_errors_and_variances_of_blocks_shorter_and_longer_than_the_parameters(length: int) -> None:
    """Thirteen parameters: both forms of the inverse against the dense one."""
    state, blocks = present((LAW, 2.0), (OTHER, 0.7)), np.arange(40) // length
    dense = np.eye(40) - state.factor @ state.factor.T
    for block in np.unique(blocks):
        inside = blocks == block
        inverse = np.linalg.inv(dense[np.ix_(inside, inside)])
        np.testing.assert_allclose(state.left_out(blocks)[inside], inverse @ state.projected[inside], rtol=1e-6)
        np.testing.assert_allclose(state.left_out_variances(blocks)[inside], inverse.diagonal(), rtol=1e-6)


def test_laws_without_a_weight_need_no_size(capfd: pytest.CaptureFixture[str]) -> None:
    """An effect that a bound holds, on a body without springs: nothing to invert, and nothing said about it."""
    nothing = np.zeros((6, 0))
    state = Present(nothing, np.zeros(0), np.arange(6.0), (nothing,), (1.0,))
    assert state.refitted() is state
    assert state.log_evidence == pytest.approx(-0.5 * 55.0)
    assert capfd.readouterr() == ("", "")
