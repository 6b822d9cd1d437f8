"""What directions explain of residuals, and those that move every row along one vector."""

import numpy as np
import pytest

from expdesign.chain.chain import Chain
from expdesign.diagnosis.evidence.columns import Along, Dense, along
from expdesign.diagnosis.library import candidates, library
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


ROWS, AXES, WIDTH = 7, 3, 2


def parallel(generator: np.random.Generator) -> Array:
    vectors, features = generator.normal(size=(ROWS, AXES)), generator.normal(size=(ROWS, WIDTH))
    features[2] = 0.0
    block: Array = vectors[:, :, None] * features[:, None]
    return block


@pytest.mark.parametrize("some", [True, False])
def test_products_are_those_of_the_matrix(some: bool) -> None:
    generator = np.random.default_rng(0)
    block, scale = parallel(generator), np.array([2.0, 0.5])
    kept = np.repeat(np.arange(ROWS) != 4, AXES) if some else None
    factored, vectors = along(block)
    assert isinstance(factored, Along)
    found = Along(factored.whole, kept, scale, vectors)
    expected = Dense(block.reshape(-1, WIDTH), kept, scale)
    np.testing.assert_allclose(found.matrix(), expected.matrix(), rtol=1e-12, atol=1e-15)
    other = generator.normal(size=(len(expected.matrix()), 4))
    carried: dict[int, Array] = {}
    for _ in range(2):  # what is carried is used again
        np.testing.assert_allclose(found.against(other, carried), expected.against(other, {}), rtol=1e-12)


def test_columns_of_another_start_share_the_vectors_or_stay_as_they_are() -> None:
    generator = np.random.default_rng(1)
    block = parallel(generator)
    _, vectors = along(block)
    again, same = along(block[:, :, ::-1] * 3.0, vectors)
    assert isinstance(again, Along)
    assert same is again.vectors is vectors
    np.testing.assert_allclose(again.matrix(), 3.0 * block[:, :, ::-1].reshape(-1, WIDTH), rtol=1e-12, atol=1e-15)
    across = block.copy()
    across[1, 0, 0] += 0.1
    different, _ = along(across, vectors)
    assert not isinstance(different, Along)
    np.testing.assert_array_equal(different.matrix(), across.reshape(-1, WIDTH))
    spoilt = np.where(np.arange(ROWS)[:, None, None] == 3, np.nan, block)
    assert not along(spoilt, vectors)[0].finite


def test_the_periods_of_an_encoder_take_as_many_numbers_as_rows() -> None:
    """A leg's length moves all readings of a row together, whatever it is a function of."""
    name = "H1"
    play = effect(name, "leg_backlash", "leg 1", "middle")
    recordings = simulated(name, play, parameters=[5e-6])
    sample, here = sample_of(name, recordings), robot(name)
    effects = [one for one in library(here, recordings) if one.physics == "encoder_periodic_error"]
    (first, *_) = candidates(effects, sample, here, base_fit(name, sample).values)
    assert len(first.directions) > 10
    assert all(isinstance(columns, Along) for columns in first.directions)
    assert all(len(columns.whole) == len(recordings) for columns in first.directions)
