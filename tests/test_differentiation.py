"""Adjoints of recorded NumPy code against central differences, and what a backward pass leaves behind."""

from collections.abc import Callable

import numpy as np
import pytest

from expdesign.arrays import FloatArray
from expdesign.mechanics.differentiation import (
    gradient,
    independent,
    inverse_root,
    one_and_gram,
    plain,
    product_transposed,
    sum_of_squares,
)

X = np.random.default_rng(3).normal(size=(2, 4, 3))
Y = np.random.default_rng(4).normal(size=(2, 5, 3))
EXPRESSIONS: dict[str, Callable[[FloatArray], FloatArray]] = {
    "reversed": lambda x: x[:, ::-1] * x,
    "repeated": lambda x: x[:, [0, 2, 2]] ** 2,
    "chosen columns": lambda x: x[..., [1, 1]] * 2.0,
    "mask": lambda x: x[:, np.array([True, False, True, True])] ** 2,
    "new axis": lambda x: x[:, None, :, 0] * x[:, :1, None, 1],
    "one element": lambda x: x[0, 0, 0] * x[1, 1, 1],
    "concatenated": lambda x: np.concatenate([x, 2.0 * x[..., :1], x**2], axis=-1) ** 2,
    "gram": lambda x: one_and_gram(x) ** 2,
    "inverse root": lambda x: inverse_root(one_and_gram(x)),
    "transposed": lambda x: product_transposed(x, Y) + product_transposed(x, Y * x[:, :1]),
    "squares": lambda x: sum_of_squares(x, -1) * sum_of_squares(x, (1, 2))[:, None],
    "triangular": lambda x: np.linalg.qr(x)[1] ** 2,
    "chosen": lambda x: np.where(X > 0.0, x**2, 3.0 * x),
    "quotient": lambda x: (x - 1.0) / (x**2 + 1.0) - 2.0 / (4.0 + x**2),
}


@pytest.mark.parametrize("name", EXPRESSIONS)
def test_gradients_are_those_of_differences(name: str) -> None:
    expression = EXPRESSIONS[name]
    value = expression(X)
    weights = np.random.default_rng(5).normal(size=np.shape(value))
    result = expression(independent(X))
    np.testing.assert_array_equal(plain(result), value)
    expected, step = np.zeros(X.shape), 1e-6
    for index in np.ndindex(X.shape):
        change = np.zeros(X.shape)
        change[index] = step
        difference = expression(X + change) - expression(X - change)
        expected[index] = (weights * difference).sum() / (2.0 * step)
    found = gradient(result, weights, X)
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-7 * np.abs(expected).max())
    # A second pass through the same record starts afresh.
    np.testing.assert_array_equal(gradient(result, weights, X), found)


def test_a_backward_pass_that_fails_leaves_nothing_behind() -> None:
    x = independent(X)
    result = np.concatenate([np.linalg.inv(x[:, :3]), x[:, :3] ** 2])
    with pytest.raises(ValueError, match="broadcast"):
        gradient(result, np.ones((4, 3, 2)), X)
    weights = np.ones((4, 3, 3))
    first = gradient(result, weights, X)
    np.testing.assert_array_equal(gradient(result, weights, X), first)
    fresh = independent(X)
    again = np.concatenate([np.linalg.inv(fresh[:, :3]), fresh[:, :3] ** 2])
    np.testing.assert_array_equal(gradient(again, weights, X), first)
