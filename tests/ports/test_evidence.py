"""Evidence and left-out errors of laws beside a base: the Gaussian model's, their largest gains, and their sizes."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from expdesign.arrays import FloatArray
from expdesign.diagnosis.evidence.state import Present
from expdesign.estimation.gaussian import Gaussian

GENERATOR = np.random.default_rng(3)
BASE = GENERATOR.standard_normal((40, 3))
LAW, OTHER = GENERATOR.standard_normal((40, 6)), GENERATOR.standard_normal((40, 4))
READINGS = GENERATOR.standard_normal(40) + LAW @ (1.5 * GENERATOR.standard_normal(6))


def present(*laws: tuple[FloatArray, float]) -> Present:
    return Present(BASE, np.zeros(3), READINGS, tuple(law for law, _ in laws), tuple(size for _, size in laws))


def unknown(*laws: tuple[FloatArray, float], scale: float = 1.0) -> Present:
    return replace(present(*laws), readings=scale * READINGS, known_noise=False)


def gaussian(*laws: tuple[FloatArray, float]) -> Gaussian:
    """The same model as a Gaussian, whose formulas have dense tests of their own."""
    deviations = [np.full(law.shape[1], np.sqrt(size)) for law, size in laws]
    columns = np.hstack([BASE, *(law for law, _ in laws)])
    return Gaussian(columns, READINGS, np.concatenate([np.full(3, np.inf), *deviations]))


def of_unknown_noise(model: Gaussian) -> float:
    """Its log evidence at the noise that is most likely."""
    return model.log_evidence + 0.5 * model.chi2 - 0.5 * (40 - 3) * np.log(model.chi2)


@pytest.mark.parametrize("length", [5, 20])
def test_closed_forms_are_those_of_the_gaussian_model(length: int) -> None:
    """Of two laws that are nearly alike beside a third; blocks are shorter and longer than the parameters are many."""
    alike = LAW + 1e-2 * GENERATOR.standard_normal(LAW.shape)
    laws, blocks = [(LAW, 2.0), (alike, 2.0), (OTHER, 0.7)], np.arange(40) // length
    fewer = [(LAW, 0.1), (OTHER, 0.7)]
    state, whole, other = present(*laws), gaussian(*laws), gaussian(*fewer)
    assert state.log_evidence - present(*fewer).log_evidence == pytest.approx(whole.log_evidence - other.log_evidence)
    gained = unknown(*laws).log_evidence - unknown(*fewer).log_evidence
    assert gained == pytest.approx(of_unknown_noise(whole) - of_unknown_noise(other))
    assert unknown(*laws).noise_variance == pytest.approx(whole.chi2 / (40 - 3))
    without = READINGS - BASE @ np.linalg.lstsq(BASE, READINGS, rcond=None)[0]
    taken = np.array([without @ law @ (size * law.T @ whole.projected) for law, size in laws])
    np.testing.assert_allclose(state.shares, taken / (without @ (READINGS - whole.projected)), rtol=1e-6)
    assert min(state.shares[:2]) > 0.35  # each of those that are alike has its half
    ends = np.cumsum([6, 6])
    for law, determined in enumerate(np.split(whole.determined, ends)):
        assert state.determined(law) == pytest.approx(determined.sum())
    np.testing.assert_allclose(state.left_out(blocks), whole.left_out(blocks), rtol=1e-6, atol=1e-8)
    projection = np.where(blocks == blocks[:, None], whole.projection(np.eye(40)), 0.0)
    np.testing.assert_allclose(state.left_out_variances(blocks), np.linalg.inv(projection).diagonal(), rtol=1e-6)
    parts = state.base @ state.weights[:3] + sum(state.moved(law) for law in range(3))
    np.testing.assert_allclose(parts, READINGS - state.projected, atol=1e-6)


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


def test_a_law_against_another_has_a_negative_share() -> None:
    """What one takes too far the other takes back: 3 − 2 = 1 along one direction."""
    along, across = np.eye(40)[:, :1], np.eye(40)[:, 1:2]
    readings = np.zeros(40)
    readings[:2] = 10.0, -20.0
    state = Present(np.zeros((40, 0)), np.zeros(0), readings, (along + across, across), (1e3, 1e3))
    assert state.shares[0] == pytest.approx(-0.2, abs=0.01)
    assert state.shares[1] == pytest.approx(1.2, abs=0.01)


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


def test_laws_without_a_weight_need_no_size(capfd: pytest.CaptureFixture[str]) -> None:
    """An effect that a bound holds, on a body without springs: nothing to invert, and nothing said about it."""
    nothing = np.zeros((6, 0))
    state = Present(nothing, np.zeros(0), np.arange(6.0), (nothing,), (1.0,))
    assert state.refitted() is state
    assert state.log_evidence == pytest.approx(-0.5 * 55.0)
    assert capfd.readouterr() == ("", "")
