"""D-optimal choice: all plans of a small pool, and the bound of Kiefer and Wolfowitz."""

from itertools import combinations_with_replacement

import numpy as np
import pytest

from expdesign.design.optimality.d_optimality import choose_d_optimal


@pytest.mark.parametrize(("rows", "count"), [(1, 3), (1, 5), (2, 2), (3, 1)])
def test_among_few_candidates_the_best_plan_is_found(rows: int, count: int) -> None:
    pool = np.random.default_rng(rows).normal(size=(12, rows, 3))
    plans = np.array(list(combinations_with_replacement(range(12), count)))
    stacked = pool[plans].reshape(len(plans), -1, 3)
    determinants = np.maximum(np.linalg.det(stacked.swapaxes(1, 2) @ stacked / count), 0.0) ** (1.0 / 3.0)
    plan = choose_d_optimal(pool, count, np.random.default_rng(0))
    assert plan.value == pytest.approx(determinants.max(), rel=1e-9)
    assert determinants.max() <= plan.bound * (1.0 + 1e-9)


def test_many_measurements_reach_the_bound() -> None:
    pool = np.random.default_rng(1).normal(size=(500, 2, 4))
    plan = choose_d_optimal(pool, 80, np.random.default_rng(0))
    assert 0.999 * plan.bound < plan.value <= plan.bound
    # A corner of a square each for two parameters: the optimum is known, det(I)^(1/2) = 1.
    corners = np.array([[[1.0, 1.0]], [[1.0, -1.0]], [[0.5, 0.5]]])
    known = choose_d_optimal(corners, 4, np.random.default_rng(0))
    assert sorted(known.chosen) == [0, 0, 1, 1]
    assert known.value == pytest.approx(1.0)
    assert known.bound == pytest.approx(1.0, rel=2e-3)
