"""Noise of deflections: whitening, its units, and the unloaded measurement that a series shares."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from expdesign.errors import InputError
from expdesign.planning.deflection_noise import DeflectionNoise, reference_whitener, series_by_pose
from tests import oracle
from tests.cases import NOISES, ROBOTS, correlated


@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("name", ROBOTS)
def test_whitened_noise_has_unit_covariance(name: str, noise: str) -> None:
    here = NOISES[noise](name)
    unit = here.whitener @ here.covariance @ here.whitener.T
    np.testing.assert_allclose(unit, np.eye(len(here.axes)), atol=1e-13)


@pytest.mark.parametrize("name", ROBOTS)
def test_deviations_are_a_diagonal_covariance(name: str) -> None:
    deviation = np.array(ROBOTS[name].deviation)
    axes = np.arange(len(deviation))
    one = DeflectionNoise.from_deviations(axes, deviation)
    other = DeflectionNoise(axes, np.diag(deviation**2))
    np.testing.assert_array_equal(one.whitener, other.whitener)
    np.testing.assert_allclose(one.whitener, np.diag(1.0 / deviation), rtol=1e-14)


def test_whitener_follows_the_unit_system() -> None:
    """Cholesky: readings in µm and mrad instead of m and rad are whitened to the same numbers."""
    covariance = correlated("H1")
    units = np.array([1e6, 1e6, 1e6, 1e3, 1e3, 1e3])
    one = DeflectionNoise(np.arange(6), covariance)
    other = DeflectionNoise(np.arange(6), covariance * np.outer(units, units))
    np.testing.assert_allclose(other.whitener * units, one.whitener, rtol=1e-12, atol=1e-9 * np.abs(one.whitener).max())


@pytest.mark.parametrize("matrix", [np.ones((2, 2)), np.array([[1.0, 2.0], [2.0, 1.0]])])
def test_covariance_that_is_not_positive_definite_is_refused(matrix: np.ndarray) -> None:
    with pytest.raises(InputError, match="not positive definite") as error:
        DeflectionNoise(np.arange(2), matrix)
    assert error.value.remedy


def test_series_are_consecutive_measurements_at_one_pose() -> None:
    a, b = [0.0, 1.0], [0.0, 2.0]
    np.testing.assert_array_equal(series_by_pose(np.array([a, a, b, a, a])), [1, 1, 2, 3, 3])
    np.testing.assert_array_equal(series_by_pose(np.array([[a], [b]])), [[1], [1]])
    np.testing.assert_array_equal(series_by_pose(np.array([[a, b], [b, b]])), [[1, 2], [1, 1]])


@given(hnp.arrays(np.int64, st.tuples(st.integers(1, 3), st.integers(1, 8)), elements=st.integers(1, 3)))
def test_reference_whitener_undoes_the_covariance_of_differences(series: np.ndarray) -> None:
    """Loaded and unloaded readings of variance ½ each; the differences of one series share the latter."""
    whitener = reference_whitener(series)
    for one, numbers in zip(whitener, series, strict=True):
        covariance = oracle.noise_covariance(np.eye(1), numbers, True)
        np.testing.assert_allclose(one @ covariance @ one.T, np.eye(len(numbers)), atol=1e-12)
