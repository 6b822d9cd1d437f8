"""What is known of parameters where some of them are held."""

import numpy as np
import pytest

from expdesign.chain.models.estimable import Estimable


def test_held_parameters_leave_the_conditional_covariance() -> None:
    """That of the others is the inverse of their block of the precision; a model file asks for exact symmetry."""
    generator = np.random.default_rng(1)
    root = generator.standard_normal((40, 40)) * 10.0 ** generator.uniform(-6, 3, 40)[:, None]
    covariance = root @ root.T
    held, others = np.array([3, 17]), np.setdiff1d(np.arange(40), [3, 17])
    found = Estimable.from_covariance(covariance).given(held).generalised
    scale = np.sqrt(np.diag(covariance))
    precision = np.linalg.inv(covariance / np.outer(scale, scale))
    expected = np.linalg.inv(precision[np.ix_(others, others)]) * np.outer(scale[others], scale[others])
    size = np.sqrt(np.diag(expected))
    np.testing.assert_allclose(
        found[np.ix_(others, others)] / np.outer(size, size), expected / np.outer(size, size), atol=1e-6
    )
    np.testing.assert_array_equal(found, found.T)
    assert not found[held].any()


def test_what_several_parameters_have_in_common_may_be_anything_and_their_differences_are_known() -> None:
    """Two parameters of which the readings show the difference alone, with 0.5: (3, 1) is 4 deviations from none."""
    along = np.array([[1.0], [1.0]]) / np.sqrt(2.0)
    known = Estimable(0.25 * np.array([[0.25, -0.25], [-0.25, 0.25]]) * 4.0, along, np.ones(2))
    both, first = np.arange(2), np.array([0])
    assert known.distance(both, np.array([3.0, 1.0])) == pytest.approx(2.0)
    assert known.distance(both, np.array([3.0, 3.0])) == pytest.approx(0.0, abs=1e-12)
    assert known.distance(first, np.array([3.0])) == 0.0
    alone = Estimable.from_covariance(np.diag([0.25, np.inf]))
    assert alone.distance(both, np.array([3.0, 1e6])) == pytest.approx(6.0)
