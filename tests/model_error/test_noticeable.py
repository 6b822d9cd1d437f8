"""The non-centrality at which a χ² test has its power."""

import numpy as np
import pytest
from scipy.stats import chi2, norm

from expdesign.assurance.model_error.settings import noncentrality
from expdesign.errors import InputError


def test_one_degree_of_freedom_is_the_two_sided_test_of_a_mean() -> None:
    # P(|z + √λ| > z_{0.995}) = 0.8; the other tail adds nothing that shows.
    root = norm.ppf(0.995) + norm.ppf(0.8)
    assert noncentrality(1) == pytest.approx(root**2, rel=1e-4)


@pytest.mark.parametrize("dof", [1, 3, 18])
def test_simulated_power(dof: int) -> None:
    shift = np.zeros(dof)
    shift[0] = np.sqrt(noncentrality(dof))
    drawn = np.random.default_rng(dof).normal(size=(40_000, dof)) + shift
    power = ((drawn**2).sum(axis=1) > chi2.ppf(0.99, dof)).mean()
    assert abs(power - 0.8) < 4.0 * np.sqrt(0.8 * 0.2 / 40_000)


def test_more_directions_or_more_power_need_more() -> None:
    values = [noncentrality(d) for d in (1, 2, 5, 21)]
    assert values == sorted(values)
    assert noncentrality(3, 0.01, 0.9) > noncentrality(3, 0.01, 0.8) > noncentrality(3, 0.05, 0.8)


@pytest.mark.parametrize(("level", "power"), [(0.0, 0.8), (0.5, 0.4), (0.01, 1.0)])
def test_tests_that_do_not_exist(level: float, power: float) -> None:
    with pytest.raises(InputError, match=r"model_error.*does not exist"):
        noncentrality(1, level, power)
