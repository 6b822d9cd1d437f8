"""The non-centrality at which a χ² test has its power."""

import numpy as np
import pytest
from scipy.stats import chi2, norm

from expdesign.assurance.model_error.settings import Assumptions
from expdesign.errors import InputError


def test_one_degree_of_freedom_is_the_two_sided_test_of_a_mean() -> None:
    # P(|z + √λ| > z_{0.995}) = 0.8; the other tail adds nothing that shows.
    root = norm.ppf(0.995) + norm.ppf(0.8)
    assert Assumptions().noncentrality(1) == pytest.approx(root**2, rel=1e-4)


@pytest.mark.parametrize("dof", [1, 3, 18])
def test_simulated_power(dof: int) -> None:
    shift = np.zeros(dof)
    shift[0] = np.sqrt(Assumptions().noncentrality(dof))
    drawn = np.random.default_rng(dof).normal(size=(40_000, dof)) + shift
    power = ((drawn**2).sum(axis=1) > chi2.ppf(0.99, dof)).mean()
    assert abs(power - 0.8) < 4.0 * np.sqrt(0.8 * 0.2 / 40_000)


def test_more_directions_or_more_power_need_more() -> None:
    assert (np.diff(Assumptions().noncentrality(np.array([1, 2, 5, 21]))) > 0.0).all()
    needed = [Assumptions(level, power).noncentrality(3) for level, power in ((0.01, 0.9), (0.01, 0.8), (0.05, 0.8))]
    assert needed[0] > needed[1] > needed[2]


@pytest.mark.parametrize(("level", "power"), [(0.0, 0.8), (0.5, 0.4), (0.01, 1.0)])
def test_tests_that_do_not_exist(level: float, power: float) -> None:
    with pytest.raises(InputError, match=r"model_error.*does not exist"):
        Assumptions(level, power)
