"""Covariances at the targets, their axes, and what an ellipse of 95 % holds."""

from typing import Any

import numpy as np
import pytest

from expdesign.planning.criteria.error_ellipses import ellipse_scale, principal_axes, target_covariances
from tests.design.problems import BIPOD, HEXAPOD, problem


@pytest.fixture(params=[BIPOD, HEXAPOD], ids=["bipod", "hexapod"])
def assessed(request: pytest.FixtureRequest) -> Any:
    case = problem(request.param)
    generator = np.random.default_rng(3)
    decisions = np.stack([case.space.sample(case.space.measurements, generator) for _ in range(4)])
    return case.assess(*case.space.decode(decisions))


def test_the_diagonals_are_the_variances_of_the_criteria(assessed: Any) -> None:
    covariances = target_covariances(assessed)
    np.testing.assert_allclose(np.diagonal(covariances.noise, axis1=-2, axis2=-1), assessed.noise_variance)
    np.testing.assert_allclose(np.diagonal(covariances.load, axis1=-2, axis2=-1), assessed.force_variance)


def test_principal_axes_are_those_of_the_covariance(assessed: Any) -> None:
    k = assessed.targets.translations
    covariance = target_covariances(assessed).total[..., :k, :k]
    sigma, axes = principal_axes(covariance)
    assert (np.diff(sigma, axis=-1) <= 0.0).all()
    rebuilt = axes @ (sigma[..., None] ** 2 * axes.swapaxes(-1, -2))
    np.testing.assert_allclose(rebuilt, covariance, rtol=1e-9, atol=1e-12 * covariance.max())


def test_what_is_not_known_has_no_axes() -> None:
    sigma, axes = principal_axes(np.array([np.eye(2), np.full((2, 2), np.nan)]))
    assert np.isfinite(sigma[0]).all()
    assert np.isnan(sigma[1]).all()
    assert np.isnan(axes[1]).all()


def test_an_ellipse_holds_its_share_of_normal_errors() -> None:
    generator = np.random.default_rng(11)
    covariance = np.array([[4.0, 1.5], [1.5, 1.0]])
    errors = generator.multivariate_normal(np.zeros(2), covariance, size=40_000)
    distance = np.sqrt(np.einsum("ki,ij,kj->k", errors, np.linalg.inv(covariance), errors))
    for probability in (0.5, 0.95):
        held = float((distance <= ellipse_scale(probability)).mean())
        standard_error = np.sqrt(probability * (1.0 - probability) / len(errors))
        assert abs(held - probability) < 4.0 * standard_error
