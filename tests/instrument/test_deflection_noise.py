"""Noise of deflections: whitening, its units, and errors drawn at random (theory.md 3 and 5.3)."""

from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from expdesign.errors import InputError
from expdesign.planning.deflection_noise import DeflectionNoise, reference_whitener, series_by_pose
from tests import oracle
from tests.cases import NOISES, ROBOTS, SOURCES, Setup, correlated, setup
from tests.oracle import Array


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


COUNT = 40_000


def drawn(here: Setup, distribution: Any = "normal") -> tuple[Array, Array]:
    """Errors (s, 3, n) of a plan whose second measurement is unloaded, and the sensitivities of its one source."""
    poses, loads, _ = here.designs(np.random.default_rng(1), 1, 3)
    loads[0, 1] = 0.0
    where = (poses[0], loads[0])
    errors = here.loaded.drawn_errors(*where, COUNT, np.random.default_rng(2), distribution)
    rotation = here.loaded.robot.jacobians(poses[0]).rotation
    return errors, here.loaded.load_errors(rotation, loads[0])[0]


@pytest.mark.parametrize("shared", [True, False], ids=["shared", "independent"])
@pytest.mark.parametrize(("load", "source"), [*product(["payload"], SOURCES), ("wrench", "direction")])
def test_covariance_across_measurements(load: str, source: str, shared: bool) -> None:
    here = setup("irregular", load, errors=((source, shared),))
    errors, sensitivity = drawn(here)
    assert not errors[:, 1].any()  # an unloaded measurement has no load error
    found = np.einsum("sin,sjm->injm", errors, errors) / COUNT
    same = np.ones((3, 3)) if shared else np.eye(3)
    expected = np.einsum("inp,jmp,ij->injm", sensitivity, sensitivity, same)
    expected[1] = expected[:, :, 1] = 0.0
    variance = np.einsum("inin->in", expected)
    scale = np.sqrt(np.maximum(np.einsum("in,jm->injm", variance, variance), 1e-300))
    assert np.abs((found - expected) / np.where(scale > 1e-20, scale, np.inf)).max() < 5.0 * np.sqrt(2.0 / COUNT)


def test_uniform_errors_have_the_same_deviation_and_are_bounded() -> None:
    here = setup("bipod", "payload", errors=(("mass", True),))
    normal, sensitivity = drawn(here)
    uniform, _ = drawn(here, "uniform")
    bound = np.sqrt(3.0) * np.abs(sensitivity[..., 0])
    assert (np.abs(uniform) <= bound + 1e-12).all()
    assert (np.abs(uniform[:, 0]).max(axis=0) > 0.999 * bound[0]).all()
    assert (np.abs(normal[:, 0]).max(axis=0) > 2.0 * bound[0]).all()
    assert uniform[:, 0].std(axis=0) == pytest.approx(normal[:, 0].std(axis=0), rel=0.02)


@pytest.mark.parametrize("noise", ["covariance", "some-axes", "shared-reference"])
def test_noise_is_white_after_scaling(noise: str) -> None:
    here = setup("irregular", "payload", noise)
    series = np.array([1, 1, 2])
    pose_map = np.broadcast_to(np.eye(6), (3, 6, 6))
    readings = here.noise.drawn(series, COUNT, np.random.default_rng(3), pose_map)
    scaled = readings @ here.noise.whitener.T
    across = 0.5 * (np.eye(3) + (series[:, None] == series)) if here.noise.shared_reference else np.eye(3)
    found = np.einsum("sik,sjl->ikjl", scaled, scaled) / COUNT
    expected = np.einsum("ij,kl->ikjl", across, np.eye(scaled.shape[-1]))
    assert np.abs(found - expected).max() < 5.0 * np.sqrt(2.0 / COUNT)
