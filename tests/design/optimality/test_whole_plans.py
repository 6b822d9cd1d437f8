"""Bounds over plans of whole measurements: against all plans that there are, and against many at random."""

from itertools import combinations_with_replacement
from typing import Any

import numpy as np
import pytest
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.oracle import Array

from expdesign.criteria.criterion import known_criteria
from expdesign.design.optimality import whole_plans
from expdesign.design.optimality.best_linear import best_linear_total
from expdesign.design.optimality.certificate import Certificate
from expdesign.design.optimality.columns import columns_of, sites_of
from expdesign.design.optimality.outer_approximation import most_sensitive
from expdesign.design.optimality.polish import polish
from expdesign.design.optimality.whole_plans import GAP, BranchAndBound, WholePlans, criterion_bounds
from expdesign.design.problem import DesignProblem
from expdesign.design.search import joined, search
from expdesign.design.start import starting_designs

POSES = [[-0.25, 0.45], [0.05, 0.5], [0.2, 0.7], [0.3, 0.9]]
TARGETS = [
    {"pose": [0.1, 0.6], "wrench": [0.0, -1000.0], "tolerance": {"dx_m": 1.0e-6}},
    {"pose": [-0.2, 0.4], "wrench": [300.0, -1000.0], "tolerance": {"dy_m": 2.0e-6}},
]
LIST = {
    "experiment.measurements": 3,
    "experiment.poses": {"candidates": POSES},
    "experiment.load": {"kind": "wrench", "fx_N": {"choices": [-500, 100, 500]}, "fy_N": {"choices": [-1000, -500]}},
    "experiment.load_error": [],
    "targets": TARGETS,
}
ERRORS = [{"source": "wrench", "std": [5.0, 8.0]}]
SHARED = {"experiment.deflection_noise.shared_reference": True}
CASES: dict[str, dict[str, Any]] = {
    "rows": {},
    "series": SHARED,
    "series-max": {**SHARED, "aggregate": "max"},
    "rows-max": {"aggregate": "max"},
    "rows-errors": {"experiment.load_error": ERRORS},
    "series-errors": {**SHARED, "experiment.load_error": ERRORS},
    "rows-errors-max": {"experiment.load_error": ERRORS, "aggregate": "max"},
    "series-errors-max": {**SHARED, "experiment.load_error": ERRORS, "aggregate": "max"},
    "rows-own-errors": {"experiment.load_error": [{**ERRORS[0], "shared": False}]},
}


def bounded(here: DesignProblem, factor: float, seconds: float = 5.0) -> tuple[float, WholePlans]:
    certificate = Certificate(here, factor)
    result = certificate.result(None)
    assert result.bound.value is not None
    return result.bound.value, BranchAndBound(here, certificate, result, None, seconds).run()


def values(here: DesignProblem, designs: Array, name: str) -> Array:
    found = known_criteria()[name].values(here.assess(*here.space.decode(designs)))
    return np.where(np.isfinite(found), found, np.inf)


def all_plans(here: DesignProblem) -> Array:
    space = here.space
    axes = np.meshgrid(*(np.arange(high + 1.0) for high in space.upper), indexing="ij")
    rows = np.array(axes).reshape(space.decisions, -1).T
    members = np.array(list(combinations_with_replacement(range(len(rows)), space.measurements)))
    return space.canonical(rows[members])


@pytest.mark.parametrize("valued", [True, False])
@pytest.mark.parametrize("name", CASES)
def test_the_best_of_all_plans(name: str, valued: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """With and without valuing the few plans that can be better one by one."""
    if not valued:
        monkeypatch.setattr(whole_plans, "_PLANS", (0, 0))
    here = problem(BIPOD, {**LIST, **CASES[name]})
    plans = all_plans(here)
    assert len(plans) == 2600
    for factor, criterion in ((0.0, "duir"), (1.0, "total")):
        best = values(here, plans, criterion).min()
        relaxed, whole = bounded(here, factor)
        assert whole.bound is not None
        assert relaxed <= whole.bound <= best * (1.0 + 1e-9)
        # What is left open is the price of whole measurements, three of them here, and branch and bound pays it.
        assert best < 1.25 * relaxed
        if valued or factor == 0.0 or not here.loaded.sources:
            assert whole.finished
            assert whole.best == pytest.approx(best, rel=1e-9)
            assert best <= whole.bound * (1.0 + 1.01 * GAP)
            assert whole.plan is not None
            assert values(here, whole.plan[None], criterion)[0] == pytest.approx(best, rel=1e-9)
        else:  # the tree's cuts are of the best linear estimator, which least squares need not reach
            assert best < 1.1 * whole.bound


@pytest.mark.parametrize("name", ["rows-errors", "series-errors", "series-errors-max", "rows-own-errors"])
def test_the_best_linear_estimator_lies_between_the_bound_and_least_squares(name: str) -> None:
    here = problem(BIPOD, {**LIST, **CASES[name]})
    plans = all_plans(here)
    found = values(here, plans, "total")
    relaxed, _ = bounded(here, 1.0, 0.0)
    some = np.flatnonzero(np.isfinite(found))[::97]
    best_linear = np.array([best_linear_total(here, plans[index]) for index in some])
    assert (best_linear <= found[some] * (1.0 + 1e-9)).all()
    assert (best_linear < found[some] * (1.0 - 1e-4)).any()
    assert relaxed <= min(best_linear_total(here, plan) for plan in plans[np.argsort(found)[:50]])
    # Without load errors both are the same.
    here = problem(BIPOD, {**LIST, **CASES[name], "experiment.load_error": []})
    expected = values(here, plans[some], "total")
    reached = [best_linear_total(here, plan) for plan in plans[some]]
    np.testing.assert_allclose(reached, expected, rtol=1e-8)


@pytest.mark.parametrize("shared", [False, True])
@pytest.mark.parametrize("measurements", [2, 4])
def test_no_load_between_the_extreme_ones_beats_the_bound(shared: bool, measurements: int) -> None:
    load = {"kind": "wrench", "fx_N": [-500.0, 500.0], "fy_N": [-1000.0, 400.0]}
    changes = {**LIST, "experiment.load": load, "experiment.measurements": measurements}
    here = problem(BIPOD, {**changes, **(SHARED if shared else {})})
    relaxed, whole = bounded(here, 0.0, 3.0)
    assert whole.bound is not None
    assert whole.bound >= relaxed
    space = here.space
    chance = starting_designs(here, 2000, np.random.default_rng(3)).reshape(-1, measurements, space.decisions)
    found = np.concatenate([chance, polish(here, chance[:20], points=4)])
    assert values(here, found, "duir").min() >= whole.bound * (1.0 - 1e-9)
    # A bound a tenth higher would be beaten.
    assert min(values(here, found, "duir").min(), whole.best) < 1.1 * whole.bound


@pytest.mark.parametrize("shared", [False, True])
def test_columns_of_no_pose_at_all_are_passed_over(shared: bool) -> None:
    """Where no column of so many measurements can be in a better plan."""
    here = problem(BIPOD, {**LIST, **(SHARED if shared else {})})
    information = Certificate(here, 0.0).information
    sites = sites_of(information)
    assert not isinstance(sites, str)
    last = Certificate(here, 0.0).result(None).last
    assert last is not None
    none = columns_of(sites, last.count, last.dual, np.inf, last.largest, 1e9)
    assert not isinstance(none, str)
    assert most_sensitive(none, last.dual, 10) == []
    assert sum(part.seconds for part in none) == 0.0


def test_a_list_for_a_hexapod_is_proved_best_to_a_thousandth() -> None:
    generator = np.random.default_rng(0)
    poses = (2.0 * generator.random((12, 6)) - 1.0) * np.array([0.03, 0.03, 0.02, 0.15, 0.15, 0.0])
    changes = {"experiment.poses": {"candidates": poses.tolist()}, "experiment.load.gravity": {"tilt_x_rad": 0.0}}
    here = problem(HEXAPOD, {**changes, "experiment.measurements": 5})
    bounds = criterion_bounds(here, 0.0, None, 5.0)
    assert bounds.whole.finished
    assert bounds.whole.gap is not None
    assert bounds.whole.gap <= GAP
    assert "the best plan there is" in bounds.lower.certified_on
    again = criterion_bounds(here, 0.0, None, 5.0)
    assert again.lower == bounds.lower
    assert again.whole.record == bounds.whole.record


def test_plans_that_branch_and_bound_finds_are_in_the_front_or_dominated_by_it() -> None:
    changes = {**LIST, **CASES["rows-errors"], "optimiser.polish": False, "optimiser.bound_seconds": 3.0}
    here = problem(BIPOD, {**changes, "optimiser.population": 4, "optimiser.generations": 1})
    front = search(here)
    found = criterion_bounds(here, 0.0, front.decisions).whole
    assert found.plan is not None
    assert found.best < front.criteria["duir"].min()
    both = joined(here, front, [None, found.plan])
    assert both.criteria["duir"].min() == pytest.approx(found.best, rel=1e-12)
    assert both.hypervolume > front.hypervolume
    assert criterion_bounds(here, 0.0, both.decisions).whole.plan is None


def test_without_time_or_with_continuous_poses_the_bound_is_that_of_the_relaxation() -> None:
    here = problem(BIPOD, {"experiment.measurements": 1})
    bounds = criterion_bounds(here, 0.0, None, 5.0)
    assert bounds.whole.bound is None
    assert "not attempted" in bounds.record["how"]
    assert bounds.lower.value is not None
    assert bounds.open is None
    known = starting_designs(here, 50, np.random.default_rng(3)).reshape(50, 1, here.space.decisions)
    bounds = criterion_bounds(here, 0.0, known, 0.0)
    assert bounds.lower.value is not None
    least = values(here, known, "duir").min()
    assert bounds.record["open"] == pytest.approx(least / bounds.lower.value - 1.0)
    listed = problem(BIPOD, LIST)
    none, some = (criterion_bounds(listed, 0.0, None, seconds) for seconds in (0.0, 5.0))
    assert none.lower.value is not None
    assert some.lower.value is not None
    assert none.lower.value <= some.lower.value
    # Of a short list, the few plans that could be better are valued even so.
    assert none.whole.finished
    assert "were valued" in none.lower.certified_on
