"""Exchanges of single measurements, and roundings: the sums are the criteria, and small spaces are solved."""

from itertools import combinations_with_replacement

import numpy as np
import pytest

from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.optimality.exchange import Exchange, rounded, variants
from expdesign.planning.problem import DesignProblem
from expdesign.planning.sampling import starting_designs
from expdesign.planning.scalarisation import Aims
from expdesign.planning.start import relaxed_designs
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.oracle import Array

SHARED = {"experiment.deflection_noise.shared_reference": True}


def candidates(here: DesignProblem, count: int, seed: int = 3) -> Array:
    space = here.space
    designs = starting_designs(here, count, np.random.default_rng(seed))
    return designs.reshape(-1, space.decisions)[:count]


def designs(here: DesignProblem, count: int) -> Array:
    return starting_designs(here, count, np.random.default_rng(5))


def criterion(here: DesignProblem, plans: Array, name: str) -> Array:
    return known_criteria()[name].values(here.assessed(here.space.canonical(plans)))


@pytest.mark.parametrize("changes", [{}, {"aggregate": "max"}, {"experiment.estimator": "weighted"}])
@pytest.mark.parametrize("base", [BIPOD, HEXAPOD])
def test_sums_over_measurements_are_the_criteria(base: dict[str, object], changes: dict[str, object]) -> None:
    here = problem(base, changes)
    plans = designs(here, 6)
    for name in ("duir", "feir", "total"):
        found = Exchange(here, (name,)).scores(plans, Aims.of_one(6))
        np.testing.assert_allclose(found, criterion(here, plans, name), rtol=1e-6)


def test_a_single_measurement_is_exchanged_where_references_are_shared() -> None:
    here = problem(BIPOD, {**SHARED, "experiment.measurements": 1})
    plans = designs(here, 3)
    found = Exchange(here, ("total",)).singles(plans, Aims.of_one(3), candidates(here, 20))
    assert (criterion(here, found, "total") <= criterion(here, plans, "total")).all()


@pytest.mark.parametrize("estimator", ["generalised", "weighted"])
@pytest.mark.parametrize("own", [False, True])
def test_sums_over_series_are_the_criteria(own: bool, estimator: str) -> None:
    """With shared references, also for measurements that join a series and for repeated ones."""
    errors = [{"source": "wrench", "std": [3.0, 3.0, 3.0, 0.3, 0.3, 0.3], "shared": not own}]
    changes = {"experiment.measurements": 4, "experiment.load_error": errors, "experiment.estimator": estimator}
    here = problem(HEXAPOD, {**SHARED, **changes})
    pose, plans = here.space.of_pose, designs(here, 6)
    plans[:3, 1] = np.where(pose, plans[:3, 0], plans[:3, 1])
    plans[:2, 2] = np.where(pose, plans[:2, 0], plans[:2, 2])
    plans[5] = plans[5, 0]
    for name in ("duir", "feir", "total"):
        exchange, expected = Exchange(here, (name,)), criterion(here, plans, name)
        told = exchange.told(plans)
        added = exchange.with_one(told[:, 1:], plans[:, 1:], plans[:, :1], told[:, :1])[:, 0]
        regular = np.isfinite(expected) & (np.arange(6) < 5)
        assert regular.sum() == 5
        for found in (exchange.sums(told, plans), added):
            np.testing.assert_allclose(exchange.distances(found, Aims.of_one(6))[regular], expected[regular], rtol=1e-6)


@pytest.mark.parametrize("changes", [{}, SHARED])
@pytest.mark.parametrize("name", ["duir", "total"])
def test_among_few_candidates_the_best_plan_is_found(name: str, changes: dict[str, object]) -> None:
    """Twelve measurements, with shared references at four poses, against all plans of them."""
    here = problem(BIPOD, {**changes, "experiment.measurements": 3})
    listed = candidates(here, 12)
    if changes:
        listed[:, here.space.of_pose] = np.repeat(listed[:4][:, here.space.of_pose], 3, axis=0)
    plans = listed[np.array(list(combinations_with_replacement(range(12), 3)))]
    best = np.nanmin(criterion(here, plans, name))
    starts = plans[::20]
    improved = Exchange(here, (name,)).singles(starts, Aims.of_one(len(starts)), listed)
    found = criterion(here, improved, name)
    assert (found <= criterion(here, starts, name) * (1.0 + 1e-9)).all()
    # Where references are shared a step away has one of its own, which no plan of the list has.
    assert found.min() <= best * (1.0 + 1e-9)
    if not changes:
        assert found.min() == pytest.approx(best, rel=1e-9)


def test_exchanges_leave_none_that_a_variant_of_one_measurement_improves() -> None:
    grid = {
        "experiment.poses": {"grid": {"x_m": [-0.3, 0.3, 3], "y_m": [0.35, 0.95, 3]}},
        "experiment.load": {"kind": "wrench", "fx_N": {"choices": [-500, 400]}, "fy_N": {"choices": [-1000, 0]}},
    }
    here = problem(BIPOD, grid)
    parents = designs(here, 12)
    found = Exchange(here, ("feir",)).singles(parents, Aims.of_one(12), parents[0], varied=True)
    reached = criterion(here, found, "feir")
    assert (reached <= criterion(here, parents, "feir") * (1.0 + 1e-12)).all()
    options = variants(here.space, found)
    for place in range(here.space.measurements):
        for variant in range(options.shape[2]):
            changed = found.copy()
            changed[:, place] = options[:, place, variant]
            values = criterion(here, changed, "feir")
            usable = np.isfinite(values)
            assert usable.any()
            assert (values[usable] >= reached[usable] * (1.0 - 1e-7)).all()


def test_repeated_measurements_are_the_best_of_all_plans_of_two() -> None:
    here = problem(BIPOD, {"experiment.measurements": 3})
    listed = candidates(here, 10)
    plans, of, scores = Exchange(here, ("feir",)).repeated(listed, Aims.of_one(1), 1, 10)
    every = listed[np.array(list(combinations_with_replacement(range(10), 3)))]
    pairs = np.array([len(np.unique(plan, axis=0)) <= 2 for plan in every])
    assert (of == 0).all()
    np.testing.assert_allclose(scores, criterion(here, plans, "feir"), rtol=1e-6)
    assert scores.min() == pytest.approx(np.nanmin(criterion(here, every[pairs], "feir")), rel=1e-6)


def test_roundings_of_the_relaxation_are_within_the_limits_of_the_legs() -> None:
    here = problem(HEXAPOD, {"robot.limits.leg_length": [0.275, 0.342]})
    poses = here.space.decode(relaxed_designs(here))[0]
    assert here.loaded.robot.usable(poses).all()


def test_rounding_takes_each_candidate_as_often_as_its_weight_says() -> None:
    weights = np.array([0.0, 0.5, 0.3, 0.2])
    plans = rounded(weights, 7, 500, np.random.default_rng(0))
    counts = (plans[:, :, None] == np.arange(4)).sum(axis=1)
    assert (np.abs(counts - 7 * weights) < 1.0).all()
    np.testing.assert_allclose(counts.mean(axis=0), 7 * weights, atol=0.1)
