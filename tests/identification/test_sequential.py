"""Sequential design: its forecast is the criterion `total`, and its choice is the best there is."""

from dataclasses import replace
from functools import reduce
from pathlib import Path

import numpy as np
import pytest

from expdesign.chain.recordings.reader import recordings_from_table
from expdesign.chain.recordings.references import reference_names
from expdesign.planning.criteria.accuracy import expected_total
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.criteria.information import Information
from expdesign.planning.deflection_noise import DeflectionNoise
from expdesign.planning.plan import Plan, plan_frame
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import read_problem
from expdesign.planning.sampling import reachable_measurements
from expdesign.planning.sequential import (
    next_measurements,
    recorded_knowledge,
)
from tests.identification.experiments import table_of

CONFIGS = Path(__file__).parents[2] / "configs"


def problem_of(name: str, *, shared_reference: bool = False) -> DesignProblem:
    problem = read_problem(CONFIGS / f"{name}.yaml")
    noise = DeflectionNoise(problem.noise.axes, problem.noise.covariance, shared_reference)
    return replace(problem, noise=noise)


def total(problem: DesignProblem, plan: Plan) -> float:
    assessment = problem.assess(plan.configurations[None], plan.loads[None], plan.series[None])
    return float(known_criteria()["total"].values(assessment)[0])


def recorded(
    problem: DesignProblem, decisions: np.ndarray, series: np.ndarray | None = None
) -> tuple[Information, Plan]:
    """What recordings of some measurements say, through the text of a file, and their plan."""
    configurations, loads = problem.space.decode(decisions)
    numbers = np.arange(1, len(decisions) + 1) if series is None else series
    plan = Plan(configurations, loads, numbers)
    frame = plan_frame(plan, problem.loaded, with_gravity=True)
    coordinates = problem.loaded.robot.coordinates
    for axis, deviation in zip(problem.noise.axes, np.sqrt(np.diag(problem.noise.covariance)), strict=True):
        frame[coordinates.deflection[axis]] = 1e-6
        frame[coordinates.deviation[axis]] = deviation
    if problem.noise.shared_reference:
        frame["reference"] = reference_names(numbers)
    return recorded_knowledge(problem, recordings_from_table(table_of(frame), problem.loaded.robot), loads, None), plan


@pytest.mark.parametrize("name", ["hexapod-h1", "hexapod-120kg", "rubin-camera"])
def test_the_forecast_is_the_criterion_total(name: str) -> None:
    problem = problem_of(name)
    decisions = reachable_measurements(problem, 5, np.random.default_rng(1))
    known, _ = recorded(problem, decisions[:3])
    each = problem.informed(decisions[3:])
    found = expected_total(reduce(Information.plus, [known, each.part(0), each.part(1)]), problem.targets)
    expected = total(problem, Plan(*problem.space.decode(decisions), np.arange(1, 6)))
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_the_forecast_with_a_shared_reference_is_the_criterion_total() -> None:
    problem = problem_of("hexapod-h1", shared_reference=True)
    decisions = reachable_measurements(problem, 4, np.random.default_rng(2))
    decisions[1, :6], decisions[3, :6] = decisions[0, :6], decisions[2, :6]
    known, plan = recorded(problem, decisions, np.array([1, 1, 2, 2]))
    found = expected_total(known, problem.targets)
    np.testing.assert_allclose(found, total(problem, plan), rtol=1e-6)


def test_one_more_measurement_is_better_than_any_of_thousands_drawn() -> None:
    problem = problem_of("hexapod-h1")
    known, _ = recorded(problem, reachable_measurements(problem, 3, np.random.default_rng(3)))
    found = next_measurements(problem, known, count=1, accuracy=None, seed=1)
    others = problem.informed(reachable_measurements(problem, 3000, np.random.default_rng(99)))
    best = expected_total(known.plus(others), problem.targets).min()
    assert found.after[0] <= best
    assert found.after[0] < found.before
    again = known.plus(problem.informed(found.decisions).part(0))
    np.testing.assert_allclose(expected_total(again, problem.targets), found.after[0])
    assert bool(problem.loaded.robot.usable(problem.space.decode(found.decisions)[0]).all())


def test_measurements_are_added_until_the_accuracy_is_reached_and_no_further() -> None:
    problem = problem_of("hexapod-h1")
    known, _ = recorded(problem, reachable_measurements(problem, 2, np.random.default_rng(4)))
    wanted = 0.7 * next_measurements(problem, known, count=1, accuracy=None, seed=1).after[0]
    found = next_measurements(problem, known, count=20, accuracy=wanted, seed=1)
    assert found.after[-1] <= wanted
    assert (found.after[:-1] > wanted).all()
    assert 1 < len(found.decisions) < 20


def test_recordings_that_determine_nothing_are_completed() -> None:
    """One loaded axis on a bipod leaves a leg open; the next measurement closes it."""
    problem = problem_of("bipod")
    problem = replace(problem, noise=DeflectionNoise.from_deviations(np.array([1]), np.array([1e-6])))
    known, _ = recorded(problem, reachable_measurements(problem, 1, np.random.default_rng(5)))
    found = next_measurements(problem, known, count=2, accuracy=None, seed=1)
    assert found.before == np.inf
    assert np.isfinite(found.after[0])
    assert found.after[1] <= found.after[0]
