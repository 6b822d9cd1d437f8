"""Batches of arrays through symbolic expressions: order of rows and columns, broadcasting, empty batches."""

import casadi as ca
import numpy as np
import pytest

from expdesign.mechanics.symbolic import BatchFunction, remembered


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


class Doubling:
    """Counts how often it builds."""

    built = 0

    @remembered
    def double(self, x: ca.SX, times: int | None = None) -> ca.SX:
        self.built += 1
        return 2.0 * x if times is None else times * x


def test_an_expression_of_the_same_symbols_is_built_once() -> None:
    x, one, other = ca.SX.sym("x", 3), Doubling(), Doubling()
    first = one.double(x)
    assert one.double(ca.vertcat(*(x[i] for i in range(3)))) is first
    assert one.double(x, 3) is not first
    assert one.double(ca.SX.sym("x", 3)) is not first
    assert one.double(x.T) is not first
    assert other.double(x) is not first
    assert (one.built, other.built) == (4, 1)


def test_few_expressions_are_kept() -> None:
    one, x = Doubling(), ca.SX.sym("x")
    first = one.double(x)
    for number in range(100):
        one.double(x, number)
    assert one.double(x) is not first
