"""The order of measuring: never dearer than any other where it is called exact, and near it elsewhere."""

from itertools import permutations

import numpy as np
import pytest

from expdesign.errors import InputError
from expdesign.planning.laboratory_sheet import EXACT, best_path, in_plan_order, ordered, path_cost
from expdesign.planning.plan import Plan
from expdesign.planning.schema import CostsSection
from tests.design.problems import priced


def distances(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    generator = np.random.default_rng(seed)
    points = generator.random((count, 2))
    return np.linalg.norm(points[:, None] - points[None], axis=-1), generator.random(count)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("count", [1, 2, 3, 6])
def test_no_order_is_shorter(count: int, seed: int) -> None:
    cost, start = distances(count, seed)
    found = best_path(cost, start)
    assert sorted(found) == list(range(count))
    least = min(path_cost(list(order), cost, start) for order in permutations(range(count)))
    assert path_cost(found, cost, start) == pytest.approx(least, rel=1e-12)


def test_more_stops_than_can_be_exact_come_near(monkeypatch: pytest.MonkeyPatch) -> None:
    ratios = []
    for seed in range(10):
        cost, start = distances(EXACT, seed)
        exact = path_cost(best_path(cost, start), cost, start)
        monkeypatch.setattr("expdesign.planning.laboratory_sheet.EXACT", 1)
        near = path_cost(best_path(cost, start), cost, start)
        monkeypatch.undo()
        assert near >= exact - 1e-12
        ratios.append(near / exact)
    assert np.mean(ratios) < 1.05


def plan(poses: list[float], loads: list[float], series: list[int]) -> Plan:
    return Plan(np.array(poses)[:, None], np.array(loads)[:, None], np.array(series))


MIXED = plan([1, 2, 1, 2, 1], [5, 10, 10, 5, 5], [1, 2, 1, 2, 1])


def test_a_shared_reference_is_read_once_a_series_and_equal_loads_follow_each_other() -> None:
    steps = ordered(MIXED, priced(2.0, 5.0, 1.0), referenced=True, shared=True)
    assert steps.rows.tolist() == [0, 0, 4, 2, 3, 3, 1]
    assert np.flatnonzero(steps.reference).tolist() == [0, 4]
    assert steps.pose_changes == 2
    assert steps.load_changes == 5  # 5, 10, off, 5, 10
    assert steps.minutes(priced(2.0, 5.0, 1.0)) == 2 * 2.0 + 5 * 5.0 + 7 * 1.0
    before = in_plan_order(MIXED, referenced=True, shared=True)
    assert before.pose_changes == 5
    assert before.minutes(priced(2.0, 5.0, 1.0)) > steps.minutes(priced(2.0, 5.0, 1.0))


def test_without_a_shared_one_every_measurement_has_its_own_reference() -> None:
    steps = ordered(MIXED, priced(), referenced=True, shared=False)
    assert steps.reference.tolist() == [True, False] * 5
    assert sorted(steps.rows[1::2].tolist()) == list(range(5))


@pytest.mark.parametrize(
    ("costs", "poses", "loads"),
    [(priced(1.0, 9.0), 3, 2), (priced(9.0, 1.0), 2, 3)],
)
def test_what_is_dear_is_changed_seldom(costs: CostsSection, poses: int, loads: int) -> None:
    """Absolute poses at every combination of two poses and two loads: either may be changed in the inner loop."""
    every = plan([1, 2, 2, 1], [5, 10, 5, 10], [1, 2, 2, 1])
    steps = ordered(every, costs, referenced=False, shared=False)
    assert not steps.reference.any()
    assert steps.exact
    assert (steps.pose_changes, steps.load_changes) == (poses, loads)
    cheapest = min(
        in_plan_order(
            Plan(every.configurations[list(o)], every.loads[list(o)], every.series[list(o)]),
            referenced=False,
            shared=False,
        ).minutes(costs)
        for o in permutations(range(4))
    )
    assert steps.minutes(costs) == cheapest


def test_among_orders_of_the_same_cost_the_way_is_short() -> None:
    steps = ordered(
        plan([0, 3, 1, 2], [5] * 4, [1, 2, 3, 4]),
        priced(1.0, 1.0),
        referenced=True,
        shared=True,
    )
    order = [0, 3, 1, 2]
    visited = [order[row] for row in steps.rows[::2]]
    assert visited in ([0, 1, 2, 3], [3, 2, 1, 0])


def test_a_series_at_two_poses_is_refused() -> None:
    with pytest.raises(InputError, match="series 1 has measurements at different poses"):
        ordered(plan([1, 2], [5, 5], [1, 1]), priced(), referenced=True, shared=True)
