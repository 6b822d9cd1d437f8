"""The union of half-spaces: exact where it is known, within Boole's bounds however rare it is."""

import numpy as np
import pytest
from scipy.special import ndtr
from scipy.stats import multivariate_normal

from expdesign.assurance.acceptance.any_axis import any_beyond


def _tails(covariance: np.ndarray, limit: float, mean: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    deviation = np.sqrt(np.diag(covariance))
    return ndtr((mean - limit) / deviation), ndtr((-mean - limit) / deviation)


@pytest.mark.parametrize("limit", [1.0, 2.0, 3.0])
@pytest.mark.parametrize("mean", [0.0, 0.7])
def test_independent_axes_multiply(limit: float, mean: float) -> None:
    above, below = _tails(np.eye(6), limit, mean)
    expected = 1.0 - np.prod(1.0 - above - below)
    assert any_beyond(above, below, np.eye(6)) == pytest.approx(expected, rel=0.03)


def test_axes_that_move_together_are_one() -> None:
    covariance = np.outer([1.0, -2.0, 3.0], [1.0, -2.0, 3.0])
    deviation = np.sqrt(np.diag(covariance))
    one = ndtr(-2.0)
    assert any_beyond(ndtr(-2.0 * deviation / deviation), np.full(3, one), covariance) == pytest.approx(
        2 * one, rel=1e-6
    )


def test_what_is_rare_stays_within_its_bounds() -> None:
    """A billionth: no draw of a plain simulation would see it."""
    generator = np.random.default_rng(1)
    root = generator.standard_normal((4, 4))
    covariance = root @ root.T
    above, below = _tails(covariance, 6.0 * np.sqrt(np.diag(covariance)).max())
    found = any_beyond(above, below, covariance, negligible=0.0)
    assert max(above + below) <= found <= float((above + below).sum())


def test_it_lies_between_the_likeliest_axis_and_certainty() -> None:
    """Also where an axis is nearly certain to be beyond, and the sum over axes is more than one."""
    generator = np.random.default_rng(3)
    for _ in range(200):
        root = generator.standard_normal((4, 4))
        above = ndtr(generator.uniform(-2.0, 4.0, 4))
        below = generator.uniform(0.0, 1.0, 4) * (1.0 - above)
        found = any_beyond(above, below, root @ root.T)
        assert (above + below).max() <= found <= 1.0


def test_it_agrees_with_the_integral() -> None:
    generator = np.random.default_rng(2)
    root = generator.standard_normal((3, 3))
    covariance = root @ root.T + 0.2 * np.eye(3)
    limit = 2.0 * np.sqrt(np.diag(covariance))
    inside = multivariate_normal(np.zeros(3), covariance).cdf(limit, lower_limit=-limit)
    above = np.full(3, ndtr(-2.0))
    assert any_beyond(above, above, covariance) == pytest.approx(1.0 - inside, rel=0.02)
