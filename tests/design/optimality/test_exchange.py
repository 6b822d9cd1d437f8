"""Choosing from candidates: the additive formula, all plans of a small space, and closeness to the bound."""

from itertools import combinations_with_replacement

import numpy as np
import pytest
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.oracle import Array

from expdesign.criteria.criterion import known_criteria
from expdesign.design.optimality.exchange import Exchange, rounded
from expdesign.design.optimality.selection import choose_measurements
from expdesign.design.problem import DesignProblem
from expdesign.design.start import starting_designs
from expdesign.errors import InfeasibleError


def candidates(here: DesignProblem, count: int, seed: int = 3) -> Array:
    space = here.space
    designs = starting_designs(here, count, np.random.default_rng(seed))
    return designs.reshape(-1, space.decisions)[:count]


def criterion(here: DesignProblem, designs: Array, name: str) -> Array:
    return known_criteria()[name].values(here.assess(*here.space.decode(designs)))


@pytest.mark.parametrize("aggregate", ["mean", "max"])
@pytest.mark.parametrize("factor", [0.0, 1.0])
def test_sums_give_the_criterion(aggregate: str, factor: float) -> None:
    here = problem(HEXAPOD, {"aggregate": aggregate})
    decisions = candidates(here, 30)
    plans = np.random.default_rng(1).integers(30, size=(12, 3))
    exchange = Exchange(here, decisions, factor)
    found = exchange.values(exchange.sums(plans))
    expected = criterion(here, decisions[plans], "total" if factor else "duir") ** 2
    np.testing.assert_allclose(found, expected, rtol=1e-6)


@pytest.mark.parametrize("with_load_errors", [False, True])
@pytest.mark.parametrize("measurements", [2, 3])
def test_among_few_candidates_the_best_plan_is_found(measurements: int, with_load_errors: bool) -> None:
    here = problem(BIPOD, {"experiment.measurements": measurements})
    decisions = candidates(here, 14)
    name = "total" if with_load_errors else "duir"
    plans = np.array(list(combinations_with_replacement(range(len(decisions)), measurements)))
    best = criterion(here, decisions[plans], name).min()
    selection = choose_measurements(here, decisions, with_load_errors=with_load_errors)
    assert selection.bound.value is not None
    assert selection.bound.value <= best * (1.0 + 1e-9)
    assert selection.value == pytest.approx(best, rel=1e-9)
    assert "all 14 measurements" in selection.bound.certified_on
    assert selection.value == pytest.approx(criterion(here, selection.variables[None], name)[0])


@pytest.mark.parametrize("factor", [0.0, 1.0])
def test_of_plans_with_shared_references_exchange_finds_the_best(factor: float) -> None:
    """Twelve candidates at four poses, against all plans."""
    changes = {"experiment.measurements": 3, "experiment.deflection_noise.shared_reference": True}
    here = problem(BIPOD, changes)
    decisions = candidates(here, 12)
    decisions[:, here.space.of_pose] = np.repeat(decisions[:4][:, here.space.of_pose], 3, axis=0)
    plans = np.array(list(combinations_with_replacement(range(12), 3)))
    exchange = Exchange(here, decisions, factor)
    expected = criterion(here, decisions[plans], "total" if factor else "duir") ** 2
    found = exchange.values(exchange.sums(plans))
    regular = np.isfinite(expected) & (expected < 1e6)
    np.testing.assert_allclose(found[regular], expected[regular], rtol=1e-5)
    improved = exchange.improve(plans[::20])
    assert exchange.values(exchange.sums(improved)).min() == pytest.approx(np.nanmin(expected), rel=1e-9)


def test_many_measurements_come_close_to_the_bound() -> None:
    here = problem(HEXAPOD, {"experiment.measurements": 40})
    selection = choose_measurements(here, candidates(here, 3000))
    assert selection.bound.value is not None
    assert selection.bound.value <= selection.value < 1.005 * selection.bound.value


def test_exchanges_only_help() -> None:
    here = problem(HEXAPOD)
    decisions = candidates(here, 200)
    exchange = Exchange(here, decisions, 1.0)
    plans = np.random.default_rng(4).integers(200, size=(5, 3))
    before, after = (exchange.values(exchange.sums(p)) for p in (plans, exchange.improve(plans)))
    assert (after < before).all()


def test_rounding_takes_each_candidate_as_often_as_its_weight_says() -> None:
    weights = np.array([0.0, 0.5, 0.3, 0.2])
    plans = rounded(weights, 7, 500, np.random.default_rng(0))
    counts = (plans[:, :, None] == np.arange(4)).sum(axis=1)
    assert (np.abs(counts - 7 * weights) < 1.0).all()
    np.testing.assert_allclose(counts.mean(axis=0), 7 * weights, atol=0.1)


def test_candidates_that_identify_too_little_are_refused() -> None:
    here = problem(BIPOD, {"experiment.deflection_noise": {"std": {"dx_m": 1e-6}}, "experiment.measurements": 1})
    with pytest.raises(InfeasibleError, match="identifies"):
        choose_measurements(here, candidates(here, 20))
