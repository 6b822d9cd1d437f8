"""Variation keeps designs inside the space, and the search meets each set of measurements in one order only."""

import numpy as np
import pytest
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.oracle import Array

from expdesign.planning.operators.recombination import CanonicalOrder, DesignCrossover, DesignMutation
from expdesign.planning.pymoo_problem import DesignPopulation
from expdesign.planning.search import search


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
