"""Criteria of the extreme singular values where two of them coincide: pieces bound them, and ends are optimal."""

import numpy as np
import pytest
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.oracle import Array

from expdesign.criteria.criterion import known_criteria
from expdesign.design.optimality.differentiated import Differentiated
from expdesign.design.problem import DesignProblem
from expdesign.design.search import search
from expdesign.design.start import starting_designs


def designs(here: DesignProblem, count: int) -> Array:
    decisions = starting_designs(here, count, np.random.default_rng(3))
    return decisions.reshape(count, here.space.measurements, here.space.decisions)


@pytest.mark.parametrize("name", ["o2", "o3", "o4"])
def test_no_piece_is_below_the_criterion_and_each_has_its_gradient(name: str) -> None:
    here = problem(HEXAPOD)
    decisions = designs(here, 3)
    found = Differentiated.of_designs(here, decisions).pieces(known_criteria()[name])
    assert len(found) == (4 if name == "o3" else 7)
    np.testing.assert_allclose(
        found[0].value, known_criteria()[name].values(here.assess(*here.space.decode(decisions)))
    )
    for piece in found[1:]:
        assert (piece.value >= found[0].value * (1.0 - 1e-12)).all()
        assert np.isfinite(piece.gradient()).all()
    decision = int(np.flatnonzero(~here.space.discrete)[0])
    step = 1e-6 * (here.space.upper - here.space.lower)[decision]
    sides = []
    for sign in (1.0, -1.0):
        moved = decisions.copy()
        moved[:, 0, decision] += sign * step
        sides.append(known_criteria()[name].values(here.assess(*here.space.decode(moved))))
    np.testing.assert_allclose(found[0].gradient()[:, 0, decision], (sides[0] - sides[1]) / (2.0 * step), rtol=1e-4)


@pytest.mark.parametrize("name", ["o2", "o3"])
def test_the_end_of_a_front_where_singular_values_coincide_satisfies_its_conditions(name: str) -> None:
    here = problem(BIPOD, {"objectives": [name, "feir"], "optimiser.polish": True})
    front = search(here)
    end = int(np.argmax(front.criteria[name]))
    values = here.assess(*here.space.decode(front.decisions[[end]])).singular_values[0]
    assert values[0] / values[-1] < 1.0 + 1e-4
    assert front.kktpm[end] < 1e-4
