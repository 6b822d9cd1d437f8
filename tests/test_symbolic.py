"""Batches of arrays through symbolic expressions: order of rows and columns, broadcasting, empty batches."""

import casadi as ca
import numpy as np
import pytest

from expdesign.mechanics.symbolic import BatchFunction


@pytest.fixture
def function() -> BatchFunction:
    x, y = ca.SX.sym("x", 2), ca.SX.sym("y", 3)
    return BatchFunction("outer", [x, y], [x @ y.T, x * 2.0, ca.SX.zeros(2, 2), ca.sum1(y)])


def test_matrices_and_vectors(function: BatchFunction) -> None:
    x, y = np.arange(8.0).reshape(4, 2), np.arange(12.0).reshape(4, 3)
    outer, double, zero, total = function(x, y)
    np.testing.assert_array_equal(outer, x[:, :, None] * y[:, None, :])
    np.testing.assert_array_equal(double, 2.0 * x)
    np.testing.assert_array_equal(zero, np.zeros((4, 2, 2)))
    np.testing.assert_array_equal(total, y.sum(axis=1, keepdims=True))


@pytest.mark.parametrize("shape", [(), (1,), (0,), (3, 0), (2, 3)])
def test_batch_dimensions_are_broadcast(function: BatchFunction, shape: tuple[int, ...]) -> None:
    generator = np.random.default_rng(0)
    x, y = generator.random((*shape, 2)), generator.random(3)
    outer, double, _, _ = function(x, y)
    np.testing.assert_array_equal(outer, x[..., :, None] * y)
    assert double.shape == (*shape, 2)


def test_arrays_that_are_not_contiguous(function: BatchFunction) -> None:
    x, y = np.arange(16.0).reshape(2, 8).T[::2], np.arange(24.0).reshape(8, 3)[::-2].astype(np.int64)
    outer, _, _, _ = function(x, y)  # type: ignore[arg-type]
    np.testing.assert_array_equal(outer, x[:, :, None] * y[:, None, :])


def test_results_are_not_overwritten_by_the_next_call(function: BatchFunction) -> None:
    first, _, _, _ = function(np.ones((2, 2)), np.ones((2, 3)))
    function(np.zeros((2, 2)), np.zeros((2, 3)))
    np.testing.assert_array_equal(first, np.ones((2, 2, 3)))
