"""Search by one criterion: against exhaustive search, and better than the front's end or chance."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.problem_file import read_problem
from expdesign.planning.sampling import starting_designs
from expdesign.planning.search import search_single

CONFIGS = Path(__file__).parents[2] / "configs"


@pytest.mark.parametrize("name", ["duir", "feir", "total", "o2", "o3"])
def test_one_measurement_of_a_bipod_is_the_best_of_a_fine_grid(name: str) -> None:
    problem = read_problem(CONFIGS / "bipod.yaml")
    criterion = known_criteria()[name]
    found = search_single(problem, criterion, seed=1, generations=30)
    x, y = np.meshgrid(np.linspace(-0.3, 0.3, 121), np.linspace(-0.3, 0.3, 121))
    decisions = np.stack([x.ravel(), y.ravel()], axis=1)[:, None, :]
    values = criterion.values(problem.assess(*problem.space.decode(decisions)))
    value = float(found.criteria[name][0])
    best = np.nanmax(values) if criterion.maximise else np.nanmin(values)
    gap = (best - value) if criterion.maximise else (value - best)
    assert gap <= 1e-3 * abs(best)


@pytest.mark.parametrize("name", ["o1", "total"])
def test_a_hexapods_design_beats_chance(name: str) -> None:
    problem = read_problem(CONFIGS / "hexapod-h1.yaml")
    criterion = known_criteria()[name]
    found = search_single(problem, criterion, seed=3, generations=4)
    drawn = starting_designs(problem, 500, np.random.default_rng(5))
    sign = -1.0 if criterion.maximise else 1.0
    values = sign * criterion.values(problem.assess(*problem.space.decode(drawn)))
    assert sign * found.criteria[name][0] < np.nanmin(values)
    configurations, loads = problem.space.decode(found.decisions)
    np.testing.assert_allclose(criterion.values(problem.assess(configurations, loads)), found.criteria[name])
    assert bool(problem.loaded.robot.usable(configurations).all())


def test_the_objectives_of_the_problem_do_not_count() -> None:
    problem = read_problem(CONFIGS / "bipod.yaml")
    other = replace(problem, objectives=(known_criteria()["o2"], known_criteria()["o4"]))
    total = known_criteria()["total"]
    first = search_single(problem, total, seed=1, generations=5)
    second = search_single(other, total, seed=1, generations=5)
    np.testing.assert_array_equal(first.decisions, second.decisions)
