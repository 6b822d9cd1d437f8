"""The bench of the estimators attains what exact compensation of the true robot does, and draws what is declared."""

from pathlib import Path

import numpy as np
import pytest

from expdesign.assurance.validation.compensation import ExactCompensation
from expdesign.estimation.identify import identify
from expdesign.planning.plan import Plan
from expdesign.planning.problem_file import read_problem
from expdesign.planning.sampling import starting_designs
from research.benchmarks.estimator import Bench

CONFIGS = Path(__file__).parents[3] / "configs"


@pytest.mark.parametrize("name", ["ur5", "hexapod-120kg"])
def test_the_attained_error_is_that_of_the_true_robot(name: str) -> None:
    problem = read_problem(CONFIGS / f"{name}.yaml")
    configurations, loads = problem.space.decode(starting_designs(problem, 1, np.random.default_rng(3))[0])
    bench = Bench(problem, Plan(configurations, loads, np.arange(1, len(configurations) + 1)))
    true = bench.compliances(0.3, (1, 0))
    recorded = bench.recorded(true, 1.0, (1, 0))
    found = bench.attempts(("weighted",), true, recorded)[0].errors
    estimate = identify(problem.loaded.robot, recorded).compliance.estimate
    for target, wrench, error in zip(problem.targets.configurations, problem.target_wrenches, found, strict=True):
        expected = ExactCompensation(problem.loaded, target, wrench, true).attained(estimate[None]).errors[0]
        np.testing.assert_allclose(error, expected, rtol=0.0, atol=1e-11)
    assert np.abs(found).max() > 1e-8


def test_load_errors_are_as_large_as_they_are_drawn() -> None:
    problem = read_problem(CONFIGS / "hexapod-120kg.yaml")
    configurations, loads = problem.space.decode(starting_designs(problem, 1, np.random.default_rng(3))[0])
    bench = Bench(problem, Plan(configurations, loads, np.arange(1, len(configurations) + 1)))
    true = problem.loaded.robot.compliance
    none, one, two = (bench.recorded(true, factor, (1, 0)).deflections for factor in (0.0, 1.0, 2.0))
    np.testing.assert_allclose(two - none, 2.0 * (one - none), rtol=1e-6, atol=1e-15)
    assert np.abs(one - none).max() > 1e-7  # 5 mm of 120 kg
