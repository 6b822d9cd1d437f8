"""Which laws are there: components are compared by what their laws explain together, and by what they predict."""

from collections.abc import Sequence

import numpy as np
import pytest

from expdesign.arrays import FloatArray
from expdesign.chain.component import BASE, INSTRUMENT, PLATFORM, Component
from expdesign.chain.ports.port import Channel, Entry
from expdesign.chain.ports.quantities import Quantity
from expdesign.diagnosis.evidence.columns import Dense
from expdesign.diagnosis.evidence.dictionary import Atom
from expdesign.diagnosis.evidence.problem import Problem
from expdesign.diagnosis.evidence.search import Search
from expdesign.diagnosis.evidence.state import Present
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.posterior import places

ROWS = 120
BLOCKS = np.repeat(np.arange(20), 6)


def _search(
    laws: Sequence[tuple[Component, FloatArray]], readings: FloatArray, seed: int, nameless: Sequence[int] = ()
) -> Search:
    """`nameless`: numbers of the laws that are of no known form."""
    base = np.random.default_rng(seed).standard_normal((ROWS, 2))
    atoms = []
    for number, (component, law) in enumerate(laws):
        scaled = law / np.sqrt((law**2).sum() / ROWS)
        gram = scaled.T @ scaled
        entry = Entry("port", component, "law", (Channel(0, 0, (Quantity("length"),)),), "constant", (1.0,), 1)
        known = {"entry": entry} if number in nameless else {"named": (None, np.zeros(1), np.ones(1))}
        atoms.append(Atom(component, Dense(scaled), gram, **known))
    return Search(Problem(Present(base, np.zeros(2), readings), atoms, BLOCKS))


@pytest.mark.parametrize("seed", range(4))
def test_physics_in_two_laws_of_one_part_is_not_given_to_another_that_resembles_both(seed: int) -> None:
    """One entry elsewhere explains more than either of two entries of the right part, but less than both."""
    generator = np.random.default_rng(seed)
    one, other, strange = (generator.standard_normal((ROWS, 1)) for _ in range(3))
    mixed = one + other + 0.3 * strange
    readings = 5.0 * (one + other)[:, 0] + generator.standard_normal(ROWS)
    search = _search([(PLATFORM, one), (PLATFORM, other), (INSTRUMENT, mixed), (BASE, other - one)], readings, seed)
    assert np.argmax(search.problem.propose(search.start).gains) == 2
    chosen = next(search.ends())
    assert chosen.components == [PLATFORM]
    found = places(search.weighed(chosen, PLATFORM))
    assert found[0].component == PLATFORM
    assert found[0].log_evidence > found[1].log_evidence + 30.0


def test_noise_has_no_law() -> None:
    generator = np.random.default_rng(9)
    laws = [(PLATFORM, generator.standard_normal((ROWS, 3))), (BASE, generator.standard_normal((ROWS, 5)))]
    assert next(_search(laws, generator.standard_normal(ROWS), 9).ends()).laws == ()


def test_combinations_of_weights_that_no_reading_shows_cost_nothing() -> None:
    """A law of many features of which two are seen has the evidence of those two."""
    generator = np.random.default_rng(5)
    seen = generator.standard_normal((ROWS, 2))
    many = seen @ generator.standard_normal((2, 40))
    readings = 3.0 * seen[:, 0] + generator.standard_normal(ROWS)
    search = _search([(PLATFORM, many)], readings, 5)
    (gain,) = search.problem.propose(search.start).gains + search.problem.prices
    assert gain == pytest.approx(search.start.state.gain(search.problem.atoms[0].directions)[0], rel=1e-9)
    assert search.problem._screen._width == 2


@pytest.mark.parametrize("seed", range(3))
def test_a_law_that_took_a_share_of_two_gives_way_to_the_one_elsewhere_that_is_left(seed: int) -> None:
    """A wide law of the platform imitates two narrow ones, one of them the base's, to a tenth or a fifth of their size.

    What it leaves of the base's law is too little beside all that is explained for a further component to be added.
    """
    generator = np.random.default_rng(seed)
    one, other = (generator.standard_normal((ROWS, 1)) for _ in range(2))
    near = np.hstack([one, other]) + [0.1, 0.2] * generator.standard_normal((ROWS, 2))
    wide = np.hstack([near, 0.3 * generator.standard_normal((ROWS, 8))])
    readings = 6.0 * (one + other)[:, 0] + generator.standard_normal(ROWS)
    search = _search([(PLATFORM, wide), (PLATFORM, other), (BASE, one)], readings, seed)
    chosen = next(search.ends())
    assert sorted(chosen.laws) == [1, 2]


def _contested(seed: int, *, apart: float) -> Search:
    """Physics of known form, a law of another part that does nearly the same, and a law of a third; readings by two."""
    generator = np.random.default_rng(seed)
    known, other = (generator.standard_normal((ROWS, 1)) for _ in range(2))
    alike = known + apart * generator.standard_normal((ROWS, 1))
    readings = 5.0 * (known + other)[:, 0] + generator.standard_normal(ROWS)
    return _search([(PLATFORM, known), (INSTRUMENT, alike), (BASE, other)], readings, seed, nameless=(1, 2))


@pytest.mark.parametrize("apart", [0.0, 1.0])
@pytest.mark.parametrize("seed", range(3))
def test_what_has_a_name_stays_beside_a_law_that_is_needed_and_one_that_does_the_same(seed: int, apart: float) -> None:
    chosen = next(_contested(seed, apart=apart).ends())
    assert sorted(chosen.laws) == [0, 2]
    assert chosen.nameless


@pytest.mark.parametrize("seed", range(3))
def test_what_has_no_name_costs_log_evidence_once(seed: int) -> None:
    problem = _contested(seed, apart=0.0).problem
    name, law, other = (problem.with_law(problem.start, index, 1.0) for index in range(3))
    assert law.price - name.price == pytest.approx(OPTIONS.nameless)
    assert problem.with_law(law, 2, 1.0).price == pytest.approx(law.price + other.price - OPTIONS.nameless)
    first, beside = problem.propose(problem.start).gains, problem.propose(other).gains
    assert first[0] - first[1] == pytest.approx(OPTIONS.nameless)
    assert beside[0] == pytest.approx(beside[1])
