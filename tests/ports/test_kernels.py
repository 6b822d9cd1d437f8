"""Covariance functions: positive semidefinite, the same as numbers and as expressions, and their features."""

import casadi as ca
import numpy as np
import pytest

from expdesign.chain.ports.features import KERNELS, basis_of

PLANAR = ("linear", "squared_exponential", "matern", "pinned", "arc_cosine", "step_cosine", "constant")


@pytest.mark.parametrize("name", sorted(KERNELS))
def test_kernels_are_covariances_and_features_give_them_back(name: str) -> None:
    generator = np.random.default_rng(1)
    inputs = generator.standard_normal((15, 2 if name in PLANAR else 1))
    basis = basis_of(name, np.full(inputs.shape[1], 1.3), inputs, 15)
    features = basis.values(inputs)
    scaled = inputs / 1.3
    covariance = KERNELS[name]([c[:, None] for c in scaled.T], [c[None, :] for c in scaled.T])
    assert np.linalg.eigvalsh(covariance).min() > -1e-9
    np.testing.assert_allclose(features @ features.T, covariance, rtol=0.0, atol=2e-4 * np.abs(covariance).max())


@pytest.mark.parametrize("name", sorted(KERNELS))
def test_expressions_say_what_numbers_say(name: str) -> None:
    generator = np.random.default_rng(2)
    inputs = generator.standard_normal((8, 2 if name in PLANAR else 1))
    basis = basis_of(name, np.full(inputs.shape[1], 0.8), inputs, 6)
    symbols = [ca.SX.sym(f"x{i}") for i in range(inputs.shape[1])]
    function = ca.Function("features", symbols, [basis.expression(symbols)])
    for point in generator.standard_normal((5, inputs.shape[1])):
        np.testing.assert_allclose(
            np.asarray(function(*point)).ravel(), basis.values(point[None])[0], rtol=1e-9, atol=1e-9
        )


def test_pinned_laws_vanish_without_their_input() -> None:
    for name in ("pinned", "wiener", "integrated_wiener"):
        basis = basis_of(name, np.array([1.0]), np.linspace(-2.0, 2.0, 9)[:, None], 8)
        np.testing.assert_allclose(basis.values(np.zeros((1, 1))), 0.0, atol=1e-9)
