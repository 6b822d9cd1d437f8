"""What is known of parameters where some of them are held."""

import numpy as np

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
