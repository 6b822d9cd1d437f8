"""Children of the best designs of each aim."""

import numpy as np
import pytest
from tests.design.optimality.test_neighbours import designs
from tests.design.problems import HEXAPOD, problem

from expdesign.design.optimality.breeding import Breeding
from expdesign.design.optimality.neighbours import Neighbours
from expdesign.design.optimality.objectives import Objectives
from expdesign.design.optimality.polish import Polishing


def test_children_have_measurements_of_their_aims_parents_alone() -> None:
    here = problem(HEXAPOD)
    known = here.settable(designs(here, 40))
    generator = np.random.default_rng(3)
    objectives = Objectives(here)
    space = here.space
    breeding = Breeding(Neighbours(here, objectives, generator), generator, (space.measurements, space.decisions, 2))
    values = objectives.values(known)
    breeding.learn(known, values)
    weights = np.array([[1.0, 0.0], [0.0, 1.0]])
    children = breeding.children(np.zeros((2, 2)), weights, np.repeat([0, 1], 20))
    assert children.shape == (40, space.measurements, space.decisions)
    for aim in (0, 1):
        best = known[np.argsort(values[:, aim])[:12]].reshape(-1, space.decisions)
        bred = children[20 * aim : 20 * (aim + 1)].reshape(-1, space.decisions)
        # One variable of one measurement may be changed.
        changed = (bred[:, None] != best[None]).sum(axis=2).min(axis=1)
        assert changed.max() <= 1
        assert (changed > 0).sum() <= 20
    np.testing.assert_array_equal(breeding.best(np.zeros((2, 2)), weights), known[values.argmin(axis=0)])


def test_descents_from_random_designs_do_not_leave_the_limits_and_bring_something() -> None:
    here = problem(HEXAPOD, {"optimiser.population": 20, "optimiser.generations": 20, "optimiser.polish": True})
    polishing = Polishing(here)
    polishing.take(designs(here, 12))
    before = polishing.front.min(axis=0)
    assert polishing.valleys() > 0.0
    assert (polishing.front.min(axis=0) < 0.9 * before).all()
    poses = here.space.decode(polishing.pool)[0]
    assert (here.loaded.robot.limit_excess(poses) <= 0.0).all()


def test_a_refinement_that_finds_nothing_new_keeps_the_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    here = problem(HEXAPOD, {"optimiser.population": 20, "optimiser.generations": 20, "optimiser.polish": True})
    polishing = Polishing(here)
    polishing.take(designs(here, 12))
    ends = polishing.front.min(axis=0)
    monkeypatch.setattr(polishing, "_minimise", lambda starts, *rest: starts)
    list(polishing.finish())
    np.testing.assert_array_equal(polishing.front.min(axis=0), ends)
