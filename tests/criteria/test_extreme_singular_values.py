"""Criteria of the extreme singular values where two of them coincide: pieces bound them, and ends are optimal."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.criteria.observability import largest_singular_value, smallest_singular_value
from expdesign.planning.optimality.differentiated import Differentiated
from expdesign.planning.problem import DesignProblem
from expdesign.planning.sampling import starting_designs
from expdesign.planning.search import search
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.oracle import Array


def designs(here: DesignProblem, count: int) -> Array:
    return starting_designs(here, count, np.random.default_rng(3))


@pytest.mark.parametrize("name", ["o2", "o3", "o4"])
def test_no_piece_is_below_the_criterion_and_each_has_its_gradient(name: str) -> None:
    here = problem(HEXAPOD)
    decisions = designs(here, 3)
    found = Differentiated.of_designs(here, decisions).pieces(known_criteria()[name])
    assert len(found) == (9 if name == "o3" else 17)
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


def assessed(whitened: Array, place: int) -> Any:
    """What the criteria ask of an assessment of one design with the whitened matrix Ã (r, L)."""
    _, values, right = np.linalg.svd(whitened[None], full_matrices=True)
    return SimpleNamespace(
        whitened=whitened[None],
        singular_values=values,
        right_singular_vectors=right,
        place=place,
        pieces=1,
        parameters=whitened.shape[1],
    )


@pytest.mark.parametrize("largest", [False, True])
def test_where_three_coincide_the_pieces_have_the_subgradients_along_them(largest: bool) -> None:
    """A piece is ‖Ã·v‖ with v held, a vector of their space; a change that leaves v alone leaves the value."""
    generator = np.random.default_rng(8)
    values = np.array([2.0, 2.0, 2.0, 1.0, 0.5]) if largest else np.array([4.0, 3.0, 1.0, 1.0, 1.0])
    left, right = (np.linalg.qr(generator.normal(size=(n, 5)))[0] for n in (9, 5))
    place = np.arange(3) if largest else np.arange(2, 5)
    extreme = largest_singular_value if largest else smallest_singular_value
    whitened = left @ np.diag(values) @ right.T
    design = assessed(whitened, 0)
    extreme(design)
    assert design.pieces == 9
    # The basis in which numpy has the three is its own.
    basis = np.linalg.svd(whitened, full_matrices=True)[2][place]
    order = basis if largest else basis[::-1]
    turned = np.linalg.norm(whitened @ order.T, axis=0)
    np.testing.assert_allclose(turned, values[place], rtol=1e-12)
    directions = [(0, 1, 0), (1, 1, 0), (1, -1, 0), (0, 0, 1), (1, 0, 1), (1, 0, -1), (0, 1, 1), (0, 1, -1)]
    for number, direction in enumerate(directions, start=1):
        vector = np.array(direction) @ order / np.linalg.norm(direction)
        expected = np.linalg.norm(whitened @ vector)
        assert extreme(assessed(whitened, number))[0] == pytest.approx(expected, rel=1e-12)
        # All others become longer, or shorter.
        change = whitened @ (np.eye(5) - np.outer(vector, vector)) * (-1e-3 if largest else 1e-3)
        assert extreme(assessed(whitened + change, 0))[0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(("name", "seed"), [("o2", 3), ("o3", 2)])  # seeds that meet that end
def test_the_end_of_a_front_where_singular_values_coincide_satisfies_its_conditions(name: str, seed: int) -> None:
    here = problem(BIPOD, {"objectives": [name, "feir"], "optimiser.polish": True, "optimiser.seed": seed})
    front = search(here)
    end = int(np.argmax(front.criteria[name]))
    values = here.assess(*here.space.decode(front.decisions[[end]])).singular_values[0]
    assert values[0] / values[-1] < 1.0 + 1e-4
    assert front.kktpm[end] < 1e-4
