"""Variation keeps designs inside the space, and the search meets each set of measurements in one order only."""

from typing import Any

import numpy as np
import pytest
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.oracle import Array

from expdesign.planning.evolution import evolution
from expdesign.planning.operators.operator import State
from expdesign.planning.operators.recombination import CanonicalOrder, DesignCrossover, DesignMutation
from expdesign.planning.optimality.exchange import Exchange
from expdesign.planning.pymoo_problem import DesignPopulation
from expdesign.planning.scalarisation import Aims
from expdesign.planning.search import search
from expdesign.planning.start import reachable_measurements, starting_designs


def parents(count: int) -> tuple[DesignPopulation, Array]:
    population = DesignPopulation(problem(HEXAPOD))
    space = population.design_problem.space
    decisions = space.sample(count * space.measurements, np.random.default_rng(0))
    return population, decisions.reshape(count, -1)


def inside(population: DesignPopulation, vectors: Array) -> None:
    space = population.design_problem.space
    decisions = population.decisions(vectors)
    assert np.all((decisions >= space.lower) & (decisions <= space.upper))
    np.testing.assert_array_equal(decisions[..., space.discrete], np.rint(decisions[..., space.discrete]))


def test_children_of_a_crossover_are_inside_the_space() -> None:
    """Every index, and with whole measurements exchanged every decision, comes from one of the parents."""
    population, vectors = parents(400)
    space = population.design_problem.space
    pairs = vectors.reshape(2, 200, -1)
    generator = np.random.default_rng(1)
    children = DesignCrossover(space)._do(population, pairs, random_state=generator)
    assert children.shape == pairs.shape
    inside(population, children.reshape(400, -1))
    indices = np.tile(space.discrete, space.measurements)
    own, other = pairs, pairs[::-1]
    from_parents = (children == own) | (children == other)
    assert from_parents[..., indices].all()
    assert (children != own).any(axis=2).mean() > 0.0
    whole = DesignCrossover(space, exchange=1.0)._do(population, pairs, random_state=generator)
    rows, own_rows, other_rows = (part.reshape(2, 200, space.measurements, -1) for part in (whole, own, other))
    kept = (rows == own_rows).all(axis=3)
    swapped = (rows == other_rows).all(axis=3)
    assert np.all(kept | swapped)
    assert abs(swapped.mean() - 0.5) < 4.0 * np.sqrt(0.25 / kept.size)
    np.testing.assert_array_equal(np.sort(whole, axis=0), np.sort(pairs, axis=0))


def test_mutants_are_inside_the_space_and_differ_in_every_gene_at_some_time() -> None:
    population, vectors = parents(2000)
    space = population.design_problem.space
    mutants = DesignMutation(space)._do(population, vectors, random_state=np.random.default_rng(2))
    inside(population, mutants)
    changed = mutants != vectors
    assert changed.any(axis=0).all()
    assert changed.mean() < 0.5


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
    found = evolution(DesignPopulation(case), drawn.reshape(60, case.space.measurements, case.space.decisions))
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
