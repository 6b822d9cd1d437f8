"""Directions that move every row along one vector are kept as that vector and a feature."""

import numpy as np
import pytest

from expdesign.diagnosis.evidence.columns import Along, Dense, along
from expdesign.diagnosis.library import candidates, library
from tests.cases import robot
from tests.diagnosis.samples import base_fit, effect, sample_of, simulated
from tests.oracle import Array

ROWS, READINGS, WIDTH = 7, 3, 2


def parallel(generator: np.random.Generator) -> Array:
    vectors, features = generator.normal(size=(ROWS, READINGS)), generator.normal(size=(ROWS, WIDTH))
    features[2] = 0.0
    block: Array = vectors[:, :, None] * features[:, None]
    return block


@pytest.mark.parametrize("some", [True, False])
def test_products_are_those_of_the_matrix(some: bool) -> None:
    generator = np.random.default_rng(0)
    block, scale = parallel(generator), np.array([2.0, 0.5])
    kept = np.repeat(np.arange(ROWS) != 4, READINGS) if some else None
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
