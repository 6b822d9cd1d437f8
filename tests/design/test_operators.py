"""Variation keeps designs inside the space, and the search meets each set of measurements in one order only."""

from typing import Any

import numpy as np
import pytest
from pymoo.core.population import Population

from expdesign.planning.loop import InTurn
from expdesign.planning.operators.state import CHILDREN, State
from expdesign.planning.optimality.exchange import Exchange
from expdesign.planning.pymoo_problem import DesignPopulation
from expdesign.planning.sampling import reachable_measurements, starting_designs
from expdesign.planning.scalarisation import Aims
from expdesign.planning.search import search
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.oracle import Array


def parents(count: int) -> tuple[DesignPopulation, Array]:
    population = DesignPopulation(problem(HEXAPOD))
    space = population.design_problem.space
    decisions = space.sample(count * space.measurements, np.random.default_rng(0))
    return population, decisions.reshape(count, -1)


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
    population = DesignPopulation(case)
    state = State(population, np.random.default_rng([3, 1]))
    values, violations = population.criteria(drawn)
    feasible = (violations <= 0.0).all(axis=1)
    state.learn(drawn[feasible], values[feasible])
    return state


class Proposes:
    """An operator that proposes one random design as often as it is asked."""

    def __init__(self, name: str) -> None:
        self.name, self.asked = name, 0

    def propose(self, state: State) -> Array:
        self.asked += 1
        space = state.problem.space
        return space.sample(space.measurements, state.generator)[None]


def test_operators_are_asked_in_turn_and_one_that_brings_nothing_less_often() -> None:
    state, operators = state_of(HEXAPOD), [Proposes("brings"), Proposes("brings nothing")]
    mating = InTurn(state, list(operators))
    names = []
    for _ in range(60):
        assert len(mating.do(state.population, Population.empty(), 10)) == 1
        names.append(mating.name)
        mating.brought(0.1 if mating.name == "brings" else 0.0)
    assert names[:6] == ["brings", "brings nothing"] * 3
    assert 8 <= operators[1].asked <= 20
    assert mating.expected == pytest.approx(0.1)


def test_a_search_ends_where_no_operator_makes_a_new_design() -> None:
    class Silent(Proposes):
        def propose(self, state: State) -> Array:
            return state.archive.designs[:0]

    mating = InTurn(state_of(HEXAPOD), [Silent("one"), Silent("other")])
    assert len(mating.do(DesignPopulation(problem(HEXAPOD)), Population.empty(), 10)) == 0


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
    assert (state.children(aims)[3:] == state.scaled(CHILDREN[0])).all()


def test_measurements_are_not_exchanged_for_variants_beyond_the_robots_limits() -> None:
    case = problem(HEXAPOD, {"robot.limits": {"leg_length": [0.265, 0.341]}})
    space, generator = case.space, np.random.default_rng(4)
    drawn = reachable_measurements(case, 8 * space.measurements, generator)
    designs = drawn.reshape(8, space.measurements, space.decisions)
    aims = Aims(np.zeros((8, 1)), np.ones((8, 1)))
    found = Exchange(case, ("total",)).singles(designs, aims, drawn, varied=True)
    assert (found != designs).any()
    assert case.reachable(found).all()
