"""What directions explain of residuals: its distribution when nothing is wrong, and what it does not depend on."""

import numpy as np
import pytest

from expdesign.chain.chain import Chain
from expdesign.diagnosis.library import candidates
from expdesign.diagnosis.locate import explained, orthonormal_basis
from expdesign.estimation.fit import fit
from tests.cases import robot
from tests.diagnosis.samples import base_fit, effect, sample_of, simulated
from tests.oracle import Array

READINGS, MODEL, COUNT = 40, 6, 4000


def problem(dimension: int, seed: int = 0) -> tuple[Array, Array, Array]:
    """A model's basis (M, r), directions (M, d), and a residual (M,) of noise with the model fitted."""
    generator = np.random.default_rng(seed)
    basis = orthonormal_basis(generator.standard_normal((READINGS, MODEL)))
    directions = generator.standard_normal((READINGS, dimension)) * [10.0**i for i in range(dimension)]
    noise = generator.standard_normal(READINGS)
    return basis, directions, noise - basis @ (basis.T @ noise)


@pytest.mark.parametrize("dimension", [1, 3, 5])
def test_without_an_effect_it_is_chi_squared(dimension: int) -> None:
    """Mean d and variance 2d, within 4 standard errors: √(2d/N) and √((12d² + 48d − 4d²)/N)."""
    basis, directions, _ = problem(dimension)
    noise = np.random.default_rng(1).standard_normal((COUNT, READINGS))
    noise -= (noise @ basis) @ basis.T
    values = np.array([explained(residuals, basis, directions)[0] for residuals in noise])
    assert values.mean() == pytest.approx(dimension, abs=4.0 * np.sqrt(2.0 * dimension / COUNT))
    error = np.sqrt((8.0 * dimension**2 + 48.0 * dimension) / COUNT)
    assert values.var() == pytest.approx(2.0 * dimension, abs=4.0 * error)


def test_only_the_space_of_the_directions_beside_the_model_counts() -> None:
    """Other parameters of the same effect, units included, and what the model explains anyway, change nothing."""
    basis, directions, residuals = problem(3)
    generator = np.random.default_rng(4)
    turned = directions @ np.diag([1.0, 0.1, 0.01]) @ generator.standard_normal((3, 3)) @ np.diag([1e-6, 1.0, 1e3])
    shifted = directions + basis @ generator.standard_normal((MODEL, 3))
    expected = explained(residuals, basis, directions)
    for other in (turned, shifted):
        assert explained(residuals, basis, other) == (pytest.approx(expected[0], rel=1e-8), 3)


def test_it_is_that_of_least_squares() -> None:
    basis, directions, residuals = problem(3)
    squares = np.linalg.lstsq(np.hstack([directions, basis]), residuals)[1]
    assert explained(residuals, basis, directions)[0] == pytest.approx(residuals @ residuals - squares[0], rel=1e-9)


def test_directions_within_the_model_explain_nothing_and_the_same_twice_counts_once() -> None:
    basis, directions, residuals = problem(1)
    inside = basis @ np.random.default_rng(5).standard_normal((MODEL, 2))
    assert explained(residuals, basis, inside) == (0.0, 0)
    twice = explained(residuals, basis, np.hstack([directions, 2.0 * directions]))
    assert twice == (pytest.approx(explained(residuals, basis, directions)[0], rel=1e-9), 1)


@pytest.mark.parametrize("name", ["irregular", "bipod-unequal"])
def test_for_a_linear_effect_it_is_what_the_full_fit_gains(name: str) -> None:
    coupling = effect(name, "leg_coupling", "leg 1", "shared with leg 2")
    sample = sample_of(name, simulated(name, coupling, parameters=[3e-8]))
    base = base_fit(name, sample)
    whole = fit(Chain(robot(name), (coupling,)), sample, np.append(base.values, 0.0))
    (candidate,) = candidates([coupling], sample, robot(name), base.values)
    basis = orthonormal_basis(base.sensitivities.reshape(-1, len(base.values)))
    found, dimension = explained(base.residuals.ravel(), basis, candidate.directions[0].matrix())
    assert found > 100.0
    assert (found, dimension) == (pytest.approx(base.chi2 - whole.chi2, rel=1e-6), 1)
