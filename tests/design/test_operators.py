"""Variation keeps designs inside the space, and the search meets each set of measurements in one order only."""

from typing import Any

import numpy as np
import pytest
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.oracle import Array

from expdesign.planning.evolution import evolution
from expdesign.planning.operators.operator import State
from expdesign.planning.operators.recombination import CanonicalOrder
from expdesign.planning.optimality.exchange import Exchange
from expdesign.planning.pymoo_problem import DesignPopulation
from expdesign.planning.sampling import reachable_measurements, starting_designs
from expdesign.planning.scalarisation import Aims
from expdesign.planning.search import search


def parents(count: int) -> tuple[DesignPopulation, Array]:
    population = DesignPopulation(problem(HEXAPOD))
    space = population.design_problem.space
    decisions = space.sample(count * space.measurements, np.random.default_rng(0))
    return population, decisions.reshape(count, -1)


def test_repair_is_the_canonical_order() -> None:
    population, vectors = parents(50)
    space = population.design_problem.space
    repaired = CanonicalOrder(space)._do(population, vectors)
    np.testing.assert_array_equal(population.decisions(repaired), space.canonical(population.decisions(vectors)))


def test_every_design_that_the_search_evaluates_is_in_canonical_order(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Array] = []
    evaluate = DesignPopulation._evaluate

    def noted(self: DesignPopulation, x: Array, out: dict[str, Array], *args: object, **kwargs: object) -> None:
        seen.append(x.astype(float))
        assert len(np.unique(seen[-1], axis=0)) == len(x)
        evaluate(self, x, out, *args, **kwargs)

    monkeypatch.setattr(DesignPopulation, "_evaluate", noted)
    case = problem(BIPOD, {"experiment.measurements": 3})
    front = search(case)
    designs = np.concatenate(seen).reshape(-1, 3, case.space.decisions)
    np.testing.assert_array_equal(case.space.canonical(designs), designs)
    assert front.evaluations == len(designs)


def state_of(base: dict[str, Any]) -> State:
    """What a search knows after its first designs."""
    case = problem(base)
    drawn = starting_designs(case, 60, np.random.default_rng(3))
    found = evolution(DesignPopulation(case), drawn)
    found.next()
    return found.state


def test_parents_are_sought_among_all_that_was_met() -> None:
    """A design that others dominate is a parent as well: its valley may have the better children."""
    state = state_of(HEXAPOD)
    known = {design.tobytes() for design in state.archive.designs}
    parents = np.concatenate(state.elite(state.ends()))
    assert len(state.met[0]) > len(state.archive)
    assert any(design.tobytes() not in known for design in parents)


def test_most_children_have_the_ends_that_no_relaxation_knows() -> None:
    state = state_of(HEXAPOD)
    aims = state.ends().joined(state.along(3))
    counts = dict(zip(state.names, state.children(aims).tolist(), strict=False))
    assert counts["feir"] > max(counts["duir"], counts["total"])
    assert (state.children(aims)[3:] == state.scaled(state.options.children[0])).all()


def test_measurements_are_not_exchanged_for_variants_beyond_the_robots_limits() -> None:
    case = problem(HEXAPOD, {"robot.limits": {"leg_length": [0.265, 0.341]}})
    space, generator = case.space, np.random.default_rng(4)
    drawn = reachable_measurements(case, 8 * space.measurements, generator)
    designs = drawn.reshape(8, space.measurements, space.decisions)
    aims = Aims(np.zeros((8, 1)), np.ones((8, 1)))
    found = Exchange(case, ("total",)).singles(designs, aims, drawn, varied=True)
    assert (found != designs).any()
    assert case.reachable(found).all()
