"""The genetic search: reproducible, within every limit, really non-dominated, right where all designs are known."""

from dataclasses import replace
from functools import cache
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import expdesign as xd
from expdesign.errors import InfeasibleError, InputError, NotIdentifiableError
from expdesign.mechanics.robots.robot import CONDITION_LIMIT
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.front import Front, hypervolume, knee, non_dominated, reference_point
from expdesign.planning.operators.exchange import drawn_exchanges
from expdesign.planning.operators.state import State
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import read_problem
from expdesign.planning.pymoo_problem import UNIDENTIFIED, DesignPopulation
from expdesign.planning.sampling import starting_designs
from expdesign.planning.search import Progress, search, search_single
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.oracle import Array

BOUNDS = "experiment.poses.bounds"


PROBLEMS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "bipod": (BIPOD, {}),
    "bipod-polished": (BIPOD, {"optimiser.polish": True}),
    "hexapod-polished": (HEXAPOD, {"optimiser.polish": True}),
    "bipod-one-measurement": (BIPOD, {"experiment.measurements": 1}),
    "bipod-over-a-singularity": (BIPOD, {f"{BOUNDS}.y_m": [-0.5, 0.6]}),
    "bipod-shared-reference": (
        BIPOD,
        {
            "experiment.poses": {"grid": {"x_m": [-0.3, 0.3, 3], "y_m": [0.4, 0.8, 2]}},
            "experiment.deflection_noise.shared_reference": True,
            "experiment.measurements": 3,
        },
    ),
    "bipod-largest-target": (
        BIPOD,
        {
            "aggregate": "max",
            "targets": [
                BIPOD["targets"][0],
                {"pose": [-0.2, 0.8], "wrench": [300.0, 0.0], "tolerance": {"dx_m": 1e-6, "dy_m": 1e-6}},
            ],
        },
    ),
    "bipod-three-objectives": (BIPOD, {"objectives": ["o3", "duir", "feir"]}),
    "hexapod": (HEXAPOD, {}),
    "hexapod-indices": (HEXAPOD, {"objectives": ["total", "o1", "o5"]}),
}


@cache
def solution(name: str) -> tuple[DesignProblem, Front]:
    """A problem of the table and its front, searched once."""
    base, changes = PROBLEMS[name]
    found = problem(base, changes)
    return found, search(found)


@pytest.fixture(params=PROBLEMS, scope="module")
def solved(request: pytest.FixtureRequest) -> tuple[DesignProblem, Front]:
    return solution(request.param)


def minimised(front: Front) -> Array:
    """Objectives (d, k) with maximised ones negated."""
    signs = [-1.0 if known_criteria()[name].maximise else 1.0 for name in front.objectives]
    return np.stack([sign * front.criteria[name] for sign, name in zip(signs, front.objectives, strict=True)], axis=1)


def dominated(values: Array) -> Array:
    """Which rows are dominated by another one, by comparing all pairs."""
    better = (values[:, None] <= values[None]).all(axis=2) & (values[:, None] < values[None]).any(axis=2)
    return np.asarray(better.any(axis=0))


def test_designs_are_inside_bounds_and_limits(solved: tuple[DesignProblem, Front]) -> None:
    case, front = solved
    space, robot = case.space, case.loaded.robot
    assert front.decisions.shape == (len(front), space.measurements, space.decisions)
    assert np.all((front.decisions >= space.lower) & (front.decisions <= space.upper))
    poses, _ = space.decode(front.decisions)
    assert np.all(robot.limit_excess(poses) <= 1e-12)
    assert np.all(robot.jacobians(poses).condition <= CONDITION_LIMIT)
    assert case.assess(*space.decode(front.decisions)).identifies_targets.all()


def test_front_is_non_dominated_and_without_duplicates(solved: tuple[DesignProblem, Front]) -> None:
    case, front = solved
    values = minimised(front)
    assert np.isfinite(values).all()
    assert not dominated(values).any()
    assert len(np.unique(values, axis=0)) == len(front)
    assert len(np.unique(case.space.canonical(front.decisions), axis=0)) == len(front)
    assert np.all(np.diff(values[:, 0]) >= 0.0)


def test_criteria_of_the_front_are_those_of_its_designs(solved: tuple[DesignProblem, Front]) -> None:
    case, front = solved
    for index in range(len(front)):
        alone = case.assessed(front.decisions[index : index + 1])
        for name, criterion in known_criteria().items():
            assert front.criteria[name][index] == pytest.approx(float(criterion.values(alone)[0]), rel=1e-9)


def test_the_recommended_design_has_the_least_total(solved: tuple[DesignProblem, Front]) -> None:
    _, front = solved
    assert front.criteria["total"][front.recommended] == front.criteria["total"].min()


@pytest.mark.parametrize("name", ["bipod-polished", "hexapod", "bipod-shared-reference"])
def test_the_same_seed_gives_the_same_bits(name: str) -> None:
    front, again = solution(name)[1], search(problem(*PROBLEMS[name]))
    np.testing.assert_array_equal(front.decisions, again.decisions)
    for criterion, values in front.criteria.items():
        np.testing.assert_array_equal(values, again.criteria[criterion])
    assert front.hypervolume == again.hypervolume


def test_progress_is_reported_every_generation() -> None:
    """Random designs and roundings of the relaxation are the first generation; every further one follows."""
    seen: list[Progress] = []
    front = search(problem(BIPOD), seen.append)
    assert [state.generation for state in seen] == [0, *range(11)]
    assert all(state.generations == 10 and len(state.front) >= 1 for state in seen)
    assert all(state.note for state in seen)
    volumes = [state.hypervolume for state in seen]
    assert volumes == sorted(volumes)
    assert front.hypervolume == pytest.approx(volumes[-1], rel=5e-3)
    assert volumes[-1] > volumes[0] > 0.0


@pytest.mark.parametrize(("effort", "other"), [("quick", "normal"), ("normal", "thorough")])
def test_more_effort_goes_on_for_longer_and_loses_nothing(effort: str, other: str) -> None:
    changes = {"optimiser": {"seed": 2, "effort": effort, "population": 20}}
    less = search(problem(HEXAPOD, changes))
    more = search(problem(HEXAPOD, {"optimiser": {**changes["optimiser"], "effort": other}}))
    assert more.evaluations > less.evaluations
    assert more.criteria["total"].min() <= less.criteria["total"].min() * (1.0 + 1e-9)
    assert more.hypervolume >= less.hypervolume * (1.0 - 2e-3)


def all_designs(case: DesignProblem) -> Array:
    """Every design of a discrete space without regard to order, (b, m, g)."""
    axes = [np.arange(int(high) + 1.0) for high in case.space.upper]
    rows = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
    return np.array([rows[list(chosen)] for chosen in combinations_with_replacement(range(len(rows)), 2)])


def test_search_finds_the_whole_front_of_a_small_discrete_space() -> None:
    """3×3 poses and 2×2 loads, two measurements: 666 designs, all of which can be evaluated."""
    case = problem(
        BIPOD,
        {
            "experiment.poses": {"grid": {"x_m": [-0.3, 0.3, 3], "y_m": [0.35, 0.95, 3]}},
            "experiment.load": {
                "kind": "wrench",
                "fx_N": {"choices": [-500, 400]},
                "fy_N": {"choices": [-1000, 0]},
            },
            "optimiser": {"population": 60, "generations": 60, "seed": 2, "polish": False},
        },
    )
    decisions = all_designs(case)
    assert len(decisions) == 666
    values, violations = DesignPopulation(case).objectives(decisions)
    usable = (violations <= 0.0).all(axis=1)
    expected = np.unique(values[usable][~dominated(values[usable])].round(9), axis=0)
    found = np.unique(minimised(search(case)).round(9), axis=0)
    assert len(expected) > 3
    np.testing.assert_allclose(found, expected, rtol=1e-8)


TINY: dict[str, dict[str, Any]] = {
    "two designs": {"experiment.measurements": 1, f"{BOUNDS}": {"x_m": {"choices": [0.1, 0.2]}, "y_m": 0.6}},
    "three designs": {"experiment.measurements": 2, f"{BOUNDS}": {"x_m": {"choices": [0.1, 0.2]}, "y_m": 0.6}},
    "one design": {"experiment.measurements": 2, f"{BOUNDS}": {"x_m": 0.1, "y_m": 0.6}},
    "one continuous decision": {"experiment.measurements": 1, f"{BOUNDS}": {"x_m": [-0.3, 0.3], "y_m": 0.6}},
    "one decision, two measurements": {"experiment.measurements": 2, f"{BOUNDS}": {"x_m": [-0.3, 0.3], "y_m": 0.6}},
}


@pytest.mark.parametrize("name", TINY)
def test_spaces_with_fewer_designs_than_the_population(name: str) -> None:
    load = {"experiment.load": {"kind": "wrench", "fx_N": 200, "fy_N": -900}}
    case = problem(BIPOD, {**TINY[name], **load})
    front = search(case)
    values = minimised(front)
    assert not dominated(values).any()
    if case.space.discrete.all():
        decisions = np.zeros((1, 2, 0)) if case.space.decisions == 0 else None
        if name == "two designs":
            decisions = np.array([[[0.0]], [[1.0]]])
        elif decisions is None:
            decisions = all_designs(case)
        every, _ = DesignPopulation(case).objectives(decisions)
        np.testing.assert_allclose(values, np.unique(every[~dominated(every)], axis=0), rtol=1e-10)


@pytest.mark.parametrize("form", ["bounds", "grid"])
def test_limits_that_no_pose_can_meet(form: str) -> None:
    poses = (
        BIPOD["experiment"]["poses"] if form == "bounds" else {"grid": {"x_m": [-0.3, 0.3, 4], "y_m": [0.4, 0.9, 4]}}
    )
    changes = {
        "robot.limits": {"leg_length": [2.0, 3.0]},
        "experiment.poses": poses,
        "targets.0.pose": [0.0, 2.5],
    }
    with pytest.raises(InfeasibleError, match=r"leg [12] would be at .* m \(limits 2 to 3 m\)") as error:
        search(problem(BIPOD, changes))
    assert error.value.where == "run.yaml"
    assert error.value.remedy


def test_poses_that_are_all_singular() -> None:
    with pytest.raises(InfeasibleError, match="singular"):
        search(problem(BIPOD, {f"{BOUNDS}.y_m": [-0.001, 0.001], f"{BOUNDS}.x_m": [0.0, 0.1]}))


def test_a_corner_of_the_space_that_sampling_alone_does_not_find() -> None:
    """Legs of a given length to a tenth of a millimetre: two circles meet in one small patch."""
    lengths = np.hypot([0.6, 0.4], 0.6)
    limits = [float(lengths.min()) - 2e-5, float(lengths.max()) + 2e-5]
    changes = {
        "robot.limits": {"leg_length": limits},
        f"{BOUNDS}": {"x_m": [0.0, 0.3], "y_m": [0.35, 0.95]},
        "targets.0.pose": [0.1, 0.6],
    }
    front = search(problem(BIPOD, changes))
    case = problem(BIPOD, changes)
    assert np.all(case.loaded.robot.limit_excess(case.space.decode(front.decisions)[0]) <= 1e-12)


@pytest.mark.parametrize(
    "changes",
    [
        {"experiment.measurements": 1, "experiment.deflection_noise": {"std": {"dx_m": 1e-6}}},
        {"experiment.load": {"kind": "wrench"}},
        {"experiment.load": {"kind": "wrench"}, "experiment.poses": {"bounds": {"x_m": 0.1, "y_m": 0.6}}},
        {"experiment.load": {"kind": "wrench"}, "experiment.poses": {"grid": {"x_m": [0.1, 0.2, 3], "y_m": 0.6}}},
    ],
    ids=["too few readings", "no load", "no load, one design", "no load, grid"],
)
def test_targets_that_no_design_can_serve(changes: dict[str, Any]) -> None:
    why = "no load acts on any actuator" if "experiment.load" in changes else "identify . of 2 stiffnesses, and d. at"
    with pytest.raises(NotIdentifiableError, match=why) as error:
        search(problem(BIPOD, changes))
    assert error.value.where == "run.yaml"
    assert error.value.remedy


def test_candidates_that_are_singular_or_out_of_reach_are_not_used(tmp_path: Path) -> None:
    (tmp_path / "poses.csv").write_text("x_m,y_m\n0.1,0.0\n0.1,0.6\n-0.2,0.55\n0.5,0.0\n0.0,3.0\n0.2,0.8\n")
    changes = {
        "experiment.poses": {"candidates": "poses.csv"},
        "robot.limits": {"leg_length": [0.1, 1.5]},
        "experiment.measurements": 3,
    }
    front = search(problem(BIPOD, changes, tmp_path))
    assert set(front.decisions[..., 0].ravel()) <= {1.0, 2.0, 5.0}


def test_population_with_singular_and_unidentified_members() -> None:
    """They violate a constraint, their objectives are not numbers to go by, and the others are as if alone."""
    case = problem(BIPOD, {f"{BOUNDS}.y_m": [-0.5, 0.9]})
    decisions = case.space.sample(8, np.random.default_rng(0)).reshape(4, 2, 4)
    decisions[..., 1] = 0.6
    decisions[1, 0, :2] = [0.1, 0.0]
    decisions[2, :, :2] = [[-0.2, 0.55], [-0.2, 0.55]]
    leg = case.loaded.robot.jacobians(np.array([-0.2, 0.55])).forward
    decisions[2, :, 2:] = np.linalg.solve(leg.T, [-700.0, 0.0])
    decisions[3, 0, 1] = 0.002
    values, violations = DesignPopulation(case).objectives(decisions)
    assert np.isfinite(values).all()
    assert np.isfinite(violations).all()
    np.testing.assert_array_equal((violations <= 0.0).all(axis=1), [True, False, False, False])
    np.testing.assert_array_equal(values[1:3], UNIDENTIFIED)
    alone, _ = DesignPopulation(case).objectives(decisions[:1])
    np.testing.assert_allclose(values[0], alone[0], rtol=1e-12)


def test_a_single_objective_gives_the_best_design() -> None:
    case = problem(BIPOD, {"objectives": ["duir"], "optimiser.polish": True})
    front = search(case)
    assert len(front) == 1
    both = solution("bipod-polished")[1]
    assert front.criteria["duir"][0] <= both.criteria["duir"].min() * (1.0 + 1e-6)


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


def test_the_objectives_of_the_problem_do_not_count() -> None:
    problem = read_problem(CONFIGS / "bipod.yaml")
    other = replace(problem, objectives=(known_criteria()["o2"], known_criteria()["o4"]))
    total = known_criteria()["total"]
    first = search_single(problem, total, seed=1, generations=5)
    second = search_single(other, total, seed=1, generations=5)
    np.testing.assert_array_equal(first.decisions, second.decisions)


def test_a_limit_of_time_ends_a_run_and_is_recorded() -> None:
    run = xd.run(problem(BIPOD, {"optimiser.polish": True}), seconds=0.0)
    assert "generation 0" in run.record["ended_by_hand"]
    assert len(run.front) >= 1


def test_whether_time_is_over_is_asked_for_every_design_that_exchanges_are_drawn_for() -> None:
    asked: list[int] = []
    case = replace(problem(HEXAPOD, {"experiment.measurements": 6}), interrupt=lambda: asked.append(1))
    population = DesignPopulation(case)
    drawn = starting_designs(case, 40, np.random.default_rng(3))
    state = State(population, np.random.default_rng(1))
    state.learn(drawn, population.criteria(drawn)[0])
    aims = state.aims(8)
    before = len(asked)
    drawn_exchanges(state, state.best(aims), aims)
    assert len(asked) - before >= len(aims)


def test_an_end_before_any_plan_is_known_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    here = problem(BIPOD, {"optimiser.polish": False})
    violated = np.ones((20, 3))
    monkeypatch.setattr(
        "expdesign.planning.pymoo_problem.DesignPopulation.criteria",
        lambda self, decisions: (np.full((len(decisions), 3), 1e30), violated[: len(decisions)]),
    )
    with pytest.raises(InputError, match="before any plan was known") as error:
        search(here, lambda state: True)
    assert error.value.remedy


VALUES = np.array([[1.0, 5.0], [2.0, 2.0], [5.0, 1.0], [3.0, 3.0], [2.0, 2.0], [1.0, 6.0]])


@given(hnp.arrays(np.float64, st.tuples(st.integers(1, 12), st.integers(2, 4)), elements=st.integers(0, 4)))
def test_non_dominated_rows_by_all_pairs(values: np.ndarray) -> None:
    expected = []
    for i, row in enumerate(values):
        beaten = any((other <= row).all() and (other < row).any() for other in values)
        repeated = any((values[j] == row).all() for j in range(i))
        if not beaten and not repeated:
            expected.append(i)
    np.testing.assert_array_equal(non_dominated(values), expected)


def test_hypervolume_by_hand() -> None:
    point = np.array([6.0, 6.0])
    assert hypervolume(VALUES[:3], point) == pytest.approx(1.0 * 1.0 + 3.0 * 4.0 + 1.0 * 5.0)
    assert hypervolume(np.array([[7.0, 0.0]]), point) == 0.0


def test_knee_is_nearest_to_the_ideal_of_the_scaled_front() -> None:
    assert knee(VALUES[:3]) == 1
    assert knee(VALUES[:3] * [1e6, 1e-6]) == 1
    assert knee(VALUES[:1]) == 0


def test_reference_point_is_worse_than_every_design() -> None:
    np.testing.assert_allclose(reference_point(VALUES), [5.4, 6.5])
    assert np.all(reference_point(VALUES[:1]) > VALUES[0])
    assert np.all(reference_point(np.array([[0.0, -2.0]])) > [0.0, -2.0])
