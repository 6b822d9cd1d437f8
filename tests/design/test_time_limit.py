"""A search that is ended: with the designs that are there, or, before any is known, by saying so."""

from dataclasses import replace

import numpy as np
import pytest

import expdesign as xd
from expdesign.errors import InputError
from expdesign.planning.operators.exchange import drawn_exchanges
from expdesign.planning.operators.state import State
from expdesign.planning.pymoo_problem import DesignPopulation
from expdesign.planning.sampling import starting_designs
from expdesign.planning.search import search
from tests.design.problems import BIPOD, HEXAPOD, problem


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
