"""Two measurements exchanged at once: how pairs are chosen, and plans that no single exchange leaves."""

from itertools import product

import numpy as np
import pytest

from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.optimality.exchange import Exchange
from expdesign.planning.optimality.plan_sums import PlanSums
from expdesign.planning.problem import DesignProblem
from expdesign.planning.sampling import reachable_measurements, starting_designs
from expdesign.planning.scalarisation import Aims
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.oracle import Array

NAMES = ("duir", "feir")
FEIR = np.array([0.0, 1.0])


def drawn(here: DesignProblem, count: int, seed: int = 5) -> Array:
    return reachable_measurements(here, count, np.random.default_rng(seed))


def values(here: DesignProblem, designs: Array, name: str) -> Array:
    return known_criteria()[name].values(here.assessed(designs))


@pytest.mark.parametrize("estimator", ["weighted", "generalised"])
@pytest.mark.parametrize("base", [BIPOD, HEXAPOD])
def test_estimates_are_exact_for_the_plan_itself_and_to_first_order_beside_it(
    base: dict[str, object], estimator: str
) -> None:
    """What M gives changes by -tr(g·dM·gᵀ); FEIR² is that of the sums S and N with the gain as it was."""
    here = problem(base, {"experiment.measurements": 4, "experiment.estimator": estimator})
    sums, design = PlanSums(here, 1.0), drawn(here, 4)
    moved = design[:2].copy()
    free = ~here.space.discrete & (here.space.upper > here.space.lower)
    moved[:, free] += 1e-6 * (here.space.upper - here.space.lower)[free]
    offered = np.concatenate([design[:2], moved])
    parts = sums.parts(design)
    noise, force = Exchange(here, NAMES).estimates(parts, np.array([0, 1]), sums.terms(sums.parts(offered)))
    assert np.sqrt(noise[0, 1]) == pytest.approx(values(here, design[None], "duir")[0], rel=1e-6)
    assert np.sqrt(force[0, 1]) == pytest.approx(values(here, design[None], "feir")[0], rel=1e-6)
    beside = np.concatenate([moved, design[2:]])
    name, by_sums = ("duir", noise) if estimator == "weighted" else ("total", noise + force)
    change = values(here, beside[None], name)[0] ** 2 - values(here, design[None], name)[0] ** 2
    assert by_sums[2, 3] - by_sums[0, 1] == pytest.approx(change, rel=1e-3)
    gain = sums.gains(parts.sum(axis=0))[0]
    moved_sums = sums.whole(sums.parts(beside).sum(axis=0))
    expected = ((gain @ moved_sums.own) * gain).sum() + ((gain @ moved_sums.shared) ** 2).sum()
    assert force[2, 3] == pytest.approx(expected, rel=1e-9)


def test_pairs_lead_to_lower_valleys_than_single_exchanges_alone() -> None:
    """From plans in which no single exchange helps, with one measurement replaced at random: errors cancel."""
    error = [{"source": "wrench", "std": [3.0, 3.0, 3.0, 0.3, 0.3, 0.3], "shared": True}]
    changes = {"experiment.measurements": 4, "experiment.load_error": error, "experiment.estimator": "weighted"}
    here = problem(HEXAPOD, changes)
    generator, count = np.random.default_rng(1), 60
    offered = drawn(here, 80)
    aims = Aims(np.zeros((count, 2)), np.tile(FEIR, (count, 1)))
    designs = starting_designs(here, count, generator)
    designs = Exchange(here, NAMES).singles(designs, aims, offered)
    designs[:, 0] = offered[generator.integers(80, size=count)]
    places = np.argsort(generator.random((count, 3, 4)), axis=2)[..., :2]
    pairs = Exchange(here, NAMES).pairs(designs, aims, places, offered)
    assert (values(here, pairs, "feir") <= values(here, designs, "feir") * (1.0 + 1e-9)).all()
    alone, both = (
        values(here, Exchange(here, NAMES).singles(each, aims, offered), "feir") for each in (designs, pairs)
    )
    difference = both - alone
    assert difference.mean() < -2.0 * difference.std() / count**0.5


@pytest.mark.parametrize("base", [BIPOD, HEXAPOD])
def test_nothing_is_better_than_the_best_of_all_pairs(base: dict[str, object]) -> None:
    here = problem(base, {"experiment.measurements": 3})
    offered = drawn(here, 30)
    designs = starting_designs(here, 4, np.random.default_rng(1))
    aims = Aims(np.zeros((4, 2)), np.tile(FEIR, (4, 1)))
    found = Exchange(here, NAMES).pairs(designs, aims, np.tile(np.array([0, 1]), (4, 1, 1)), offered)
    pairs = offered[np.array(list(product(range(30), repeat=2)))]
    for before, after in zip(designs, found, strict=True):
        rest = np.broadcast_to(before[2:], (len(pairs), 1, before.shape[1]))
        every = values(here, np.concatenate([pairs, rest], axis=1), "feir")
        own = values(here, before[None], "feir")[0]
        reached = values(here, after[None], "feir")[0]
        assert min(np.nanmin(every), own) * (1.0 - 1e-6) <= reached <= own * (1.0 + 1e-9)


def test_what_no_pair_improves_stays_as_it_is() -> None:
    here = problem(HEXAPOD)
    designs = starting_designs(here, 3, np.random.default_rng(2))
    aims = Aims(np.zeros((3, 2)), np.tile(FEIR, (3, 1)))
    places = np.tile(np.array([0, 1]), (3, 1, 1))
    same = Exchange(here, NAMES).pairs(designs, aims, places, designs[0, :1])
    better = values(here, same, "feir") <= values(here, designs, "feir")
    assert (better | (same == designs).all(axis=(1, 2))).all()
    assert Exchange(here, NAMES).pairs(designs[:0], aims[:0], places[:0], designs[0]).shape[0] == 0
