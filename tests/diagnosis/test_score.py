"""Score tests: their distribution when nothing is wrong, what they do not depend on, and how they bound parameters."""

import numpy as np
import pytest
from tests.cases import robot
from tests.diagnosis.samples import base_fit, effect, sample_of, simulated
from tests.oracle import Array

from expdesign.chain.chain import Chain
from expdesign.diagnosis.library import candidates
from expdesign.diagnosis.score import orthonormal_basis, score
from expdesign.estimation.fit import fit

READINGS, MODEL, COUNT = 40, 6, 4000


def problem(dimension: int, seed: int = 0) -> tuple[Array, Array, Array]:
    """A model's basis (M, r), directions (1, M, d), and a residual (M,) of noise with the model fitted."""
    generator = np.random.default_rng(seed)
    basis = orthonormal_basis(generator.standard_normal((READINGS, MODEL)))
    directions = generator.standard_normal((1, READINGS, dimension)) * [10.0**i for i in range(dimension)]
    noise = generator.standard_normal(READINGS)
    return basis, directions, noise - basis @ (basis.T @ noise)


def statistics(dimension: int, one_sided: list[bool]) -> Array:
    basis, directions, _ = problem(dimension)
    noise = np.random.default_rng(1).standard_normal((COUNT, READINGS))
    noise -= (noise @ basis) @ basis.T
    return np.array([score(r, basis, directions, np.array(one_sided)).statistic for r in noise])


@pytest.mark.parametrize("dimension", [1, 3, 5])
def test_without_an_effect_the_statistic_is_chi_squared(dimension: int) -> None:
    """Mean d and variance 2d, within 4 standard errors: √(2d/N) and √((12d² + 48d − 4d²)/N)."""
    values = statistics(dimension, [False] * dimension)
    assert values.mean() == pytest.approx(dimension, abs=4.0 * np.sqrt(2.0 * dimension / COUNT))
    error = np.sqrt((8.0 * dimension**2 + 48.0 * dimension) / COUNT)
    assert values.var() == pytest.approx(2.0 * dimension, abs=4.0 * error)


def test_a_one_sided_parameter_explains_half_the_time() -> None:
    """½χ²₀ + ½χ²₁: mean ½, variance 5/4, zero in half the cases."""
    values = statistics(1, [True])
    assert values.mean() == pytest.approx(0.5, abs=4.0 * np.sqrt(1.25 / COUNT))
    assert (values == 0.0).mean() == pytest.approx(0.5, abs=4.0 * np.sqrt(0.25 / COUNT))


def test_one_sided_parameters_are_never_negative_and_never_gain_from_it() -> None:
    generator = np.random.default_rng(2)
    basis, directions, _ = problem(4)
    sided = np.array([True, False, True, True])
    negative_otherwise = 0
    for _ in range(200):
        residuals = generator.standard_normal(READINGS)
        free, bounded = (score(residuals, basis, directions, s) for s in (np.zeros(4, dtype=bool), sided))
        assert (bounded.step[sided] >= 0.0).all()
        assert bounded.statistic <= free.statistic * (1.0 + 1e-12)
        negative_otherwise += bool((free.step[sided] < 0.0).any())
    assert negative_otherwise > 100


def test_what_the_model_explains_changes_nothing() -> None:
    basis, directions, residuals = problem(3)
    sided = np.zeros(3, dtype=bool)
    expected = score(residuals, basis, directions, sided)
    generator = np.random.default_rng(3)
    mixed = directions + basis @ generator.standard_normal((MODEL, 3))
    shifted = residuals + basis @ generator.standard_normal(MODEL)
    for found in (score(residuals, basis, mixed, sided), score(shifted, basis, directions, sided)):
        assert found.statistic == pytest.approx(expected.statistic, rel=1e-9)
        np.testing.assert_allclose(found.step, expected.step, rtol=1e-9)


def test_only_the_space_of_the_directions_counts() -> None:
    """Other parameters of the same effect, units included, explain as much."""
    basis, directions, residuals = problem(3)
    mixed = np.random.default_rng(4).standard_normal((3, 3))
    turn = np.diag([1.0, 0.1, 0.01]) @ mixed @ np.diag([1e-6, 1.0, 1e3])
    sided = np.zeros(3, dtype=bool)
    plain, other = score(residuals, basis, directions, sided), score(residuals, basis, directions @ turn, sided)
    assert other.statistic == pytest.approx(plain.statistic, rel=1e-8)
    np.testing.assert_allclose(turn @ other.step, plain.step, rtol=1e-6)


def test_statistic_and_step_are_those_of_least_squares() -> None:
    basis, directions, residuals = problem(3)
    found = score(residuals, basis, directions, np.zeros(3, dtype=bool))
    design = np.hstack([directions[0], basis])
    solution, squares, *_ = np.linalg.lstsq(design, residuals)
    np.testing.assert_allclose(found.step, solution[:3], rtol=1e-9)
    assert found.statistic == pytest.approx(residuals @ residuals - squares[0], rel=1e-9)
    assert found.dimension == 3


def test_directions_within_the_model_explain_nothing() -> None:
    basis, _, residuals = problem(1)
    inside = (basis @ np.random.default_rng(5).standard_normal((MODEL, 2)))[None]
    found = score(residuals, basis, inside, np.zeros(2, dtype=bool))
    assert (found.statistic, found.dimension) == (0.0, 0)
    np.testing.assert_array_equal(found.step, np.zeros(2))


def test_the_same_direction_twice_counts_once() -> None:
    basis, directions, residuals = problem(1)
    once = score(residuals, basis, directions, np.zeros(1, dtype=bool))
    twice = score(residuals, basis, np.concatenate([directions, 2.0 * directions], axis=2), np.zeros(2, dtype=bool))
    assert twice.dimension == 1
    assert twice.statistic == pytest.approx(once.statistic, rel=1e-9)


def test_the_best_start_wins() -> None:
    basis, _, residuals = problem(1)
    generator = np.random.default_rng(6)
    starts = generator.standard_normal((5, READINGS, 2))
    starts[3, :, 0] = residuals
    found = score(residuals, basis, starts, np.zeros(2, dtype=bool))
    assert found.start == 3
    assert found.statistic == pytest.approx(residuals @ residuals, rel=1e-9)


@pytest.mark.parametrize("name", ["irregular", "bipod-unequal"])
def test_for_a_linear_effect_it_is_what_the_full_fit_gains(name: str) -> None:
    coupling = effect(name, "leg_coupling", "leg 1", "shared with leg 2")
    recordings = simulated(name, coupling, parameters=[3e-8])
    sample = sample_of(name, recordings)
    base = base_fit(name, sample)
    whole = fit(Chain(robot(name), (coupling,)), sample, np.append(base.values, 0.0))
    (candidate,) = candidates([coupling], sample, robot(name), base.values)
    basis = orthonormal_basis(base.sensitivities.reshape(-1, len(base.values)))
    found = score(base.residuals.ravel(), basis, candidate.directions, candidate.one_sided)
    assert found.statistic > 100.0
    assert found.statistic == pytest.approx(base.chi2 - whole.chi2, rel=1e-6)
    assert found.step[0] == pytest.approx(whole.values[-1], rel=1e-6)
