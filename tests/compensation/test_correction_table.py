"""Interpolation of corrections: exact where it must be, its bound where the curvature is known, and never beyond it."""

import numpy as np
import pytest

from expdesign.arrays import FloatArray
from expdesign.errors import ConvergenceError
from expdesign.estimation.compensation.correction_table import CorrectionGrid, correction_table

LOW, HIGH = np.array([-1.0, 0.0, 2.0]), np.array([1.0, 3.0, 2.5])


def test_a_multilinear_function_is_interpolated_exactly_by_two_nodes() -> None:
    def exact(points: FloatArray) -> FloatArray:
        x, y, z = points.T
        return np.stack([1.0 + x - 2.0 * y * z + 3.0 * x * y * z, x * z], axis=1)

    table = correction_table(exact, LOW, HIGH, np.array([1e-9, 1e-9]), most=100)
    assert table.grid.counts.tolist() == [2, 2, 2]
    points = table.grid.random(200, np.random.default_rng(2))
    np.testing.assert_allclose(table.grid.interpolate(table.values, points), exact(points), atol=1e-13)


def test_the_bound_is_that_of_a_quadratic_function() -> None:
    """x² has the error h²/8·2 in the middle of a cell, along every axis at once."""

    def exact(points: FloatArray) -> FloatArray:
        return (points**2).sum(axis=1, keepdims=True)

    table = correction_table(exact, LOW, HIGH, np.array([0.02]), most=10_000)
    steps = (HIGH - LOW) / (table.grid.counts - 1)
    assert table.found[0] == pytest.approx((steps**2).sum() / 4.0, rel=1e-9)
    assert table.bound[0] == pytest.approx(1.5 * (steps**2).sum() / 4.0, rel=1e-6)
    assert table.found[0] < table.stated[0] <= 0.02


@pytest.mark.parametrize("seed", range(5))
def test_smooth_functions_stay_within_what_is_stated(seed: int) -> None:
    generator = np.random.default_rng(seed)
    waves, phases = generator.normal(size=(2, 3)), generator.random(2)

    def exact(points: FloatArray) -> FloatArray:
        return np.sin(points @ waves.T + phases)

    table = correction_table(exact, LOW, HIGH, np.array([0.01, 0.05]), most=100_000, seed=seed)
    points = table.grid.random(20_000, generator)
    errors = np.abs(table.grid.interpolate(table.values, points) - exact(points)).max(axis=0)
    assert np.all(errors <= table.stated)
    assert np.all(table.stated <= [0.01, 0.05])


def test_a_kink_that_no_derivative_tells_is_found_at_the_points() -> None:
    def exact(points: FloatArray) -> FloatArray:
        return np.maximum(points[:, :1] - 0.9371, 0.0)

    table = correction_table(exact, LOW, HIGH, np.array([1e-3]), most=100_000)
    points = table.grid.random(20_000, np.random.default_rng(7))
    assert np.abs(table.grid.interpolate(table.values, points) - exact(points)).max() <= table.stated[0] <= 1e-3


def test_too_many_nodes_are_refused() -> None:
    with pytest.raises(ConvergenceError, match="more than 50 nodes") as error:
        correction_table(lambda points: np.sin(9.0 * points), LOW, HIGH, np.full(3, 1e-3), most=50)
    assert error.value.remedy


def test_nodes_run_with_the_last_axis_fastest() -> None:
    grid = CorrectionGrid(LOW, HIGH, np.array([2, 3, 2]))
    np.testing.assert_array_equal(grid.nodes[:3], [[-1, 0, 2], [-1, 0, 2.5], [-1, 1.5, 2]])
    np.testing.assert_allclose(grid.interpolate(grid.nodes, grid.nodes), grid.nodes, atol=1e-15)
