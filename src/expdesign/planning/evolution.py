"""The search: NSGA-II (Deb et al. 2002) whose operators know exchanges of measurements and exact gradients.

A generation asks one operator for designs. Which one is decided by what each has brought per second of counted work
(`operators/operator.py`), so that the same seed gives the same front. Survival is NSGA-II's; every design that nothing
dominates is kept in an archive beside the population.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.population import Population
from pymoo.core.termination import Termination

from expdesign.arrays import FloatArray
from expdesign.planning.operators.continuation import Continuation, FrontDescent
from expdesign.planning.operators.exchange import PairExchange, SingleExchange
from expdesign.planning.operators.operator import WEIGHTS, Archive, Credit, Operator, State
from expdesign.planning.operators.recombination import CanonicalOrder, Recombination
from expdesign.planning.options import EXPECTED_GAIN, SearchOptions
from expdesign.planning.pymoo_problem import DesignPopulation


def operators_of(state: State, mate: Callable[[int], Population]) -> list[Operator]:
    """The operators that have anything to do in a problem."""
    problem = state.problem
    found: list[Operator] = [Recombination(mate), SingleExchange()]
    if state.sums and (problem.space.settings is None or problem.budget is None):
        found.append(PairExchange())
    if state.smooth:
        found.append(FrontDescent())
    if len(problem.objectives) == 2:
        found.append(Continuation())
    return found


class Evolution(NSGA2):  # type: ignore[misc]
    """NSGA-II with further operators.

    Args:
        state: what the search knows, its archive empty.
        first: designs (b, m, g) of the first generation.

    Attributes:
        state: what the search knows.
        operators: who makes designs.
        asked: the operator of the present generation, by number.
        history_of_work: counted seconds and gain of every generation.
    """

    def __init__(self, state: State, first: FloatArray, **settings: Any) -> None:
        self.state = state
        self.pop: Any
        vectors = np.unique(first.reshape(len(first), -1), axis=0)
        space = state.problem.space
        super().__init__(
            pop_size=state.options.population,
            sampling=Population.new(X=vectors),
            repair=CanonicalOrder(space),
            **settings,
        )
        self.operators: list[Operator] = []
        self.credit = Credit(0, 0, 0.0)
        self.history_of_work: list[tuple[float, float]] = []
        self.asked = 0

    def _initialize_infill(self) -> Population:
        return self.initialization.sampling

    def _initialize_advance(self, infills: Population | None = None, **kwargs: Any) -> None:
        self._take(infills)
        self.operators = operators_of(self.state, self._mate)
        self.credit = Credit(len(self.operators), self.state.options.floor, self.state.options.memory)

    def _mate(self, count: int) -> Population:
        """NSGA-II's children of survivors."""
        state = self.random_state
        return self.mating.do(self.problem, self.pop, count, algorithm=self, random_state=state)

    def _infill(self) -> Population:
        state = self.state
        before = state.work.seconds
        state.work.called()
        self.asked = self.credit.choose() if len(state.archive) else 0
        designs = self.operators[self.asked].offspring(state)
        designs = state.problem.settable(designs) if len(designs) else designs
        state.work.evaluated(*designs.shape[:2])
        self._spent = state.work.seconds - before
        return Population.new(X=_distinct(designs.reshape(len(designs), self.problem.n_var), state.archive))

    def _advance(self, infills: Population | None = None, **kwargs: Any) -> None:
        gain = self._take(infills)
        self.credit.learn(self.asked, gain, self._spent)
        self.history_of_work.append((self._spent, gain))

    def _take(self, infills: Population | None) -> float:
        """Archive and survival; what the designs bring."""
        state, gain = self.state, 0.0
        merged = infills if self.pop is None or self.pop is infills else self.pop
        if infills is not None and len(infills):
            designs = state.population.decisions(infills.get("X").astype(float))
            feasible = (infills.get("G") <= 0.0).all(axis=1)
            gain = state.archive.add(designs[feasible], infills.get("criteria").astype(float)[feasible])
            state.learn(designs[feasible], infills.get("criteria").astype(float)[feasible])
            if merged is not infills:
                merged = Population.merge(self.pop, infills)
        self.pop = self.survival.do(
            self.problem, merged, n_survive=self.pop_size, algorithm=self, random_state=self.random_state
        )
        return gain

    def take(self, designs: FloatArray) -> None:
        """Further designs (b, m, g) of the first generation."""
        vectors = _distinct(
            self.state.problem.settable(designs).reshape(len(designs), self.problem.n_var), self.state.archive
        )
        infills = Population.new(X=vectors)
        self.evaluator.eval(self.problem, infills)
        self._take(infills)


def _distinct(vectors: FloatArray, archive: Archive) -> FloatArray:
    """Vectors (b, n) that are neither twice among them nor in the archive."""
    if len(vectors) == 0:
        return vectors
    known = {design.tobytes() for design in archive.designs}
    first = np.sort(np.unique(vectors, axis=0, return_index=True)[1])
    return vectors[[index for index in first if vectors[index].tobytes() not in known]]


class ExpectedGain(Termination):  # type: ignore[misc]
    """Ends a search of which a further second of work is expected to bring next to nothing.

    Expected is what the last second brought, or half of what the one before did. A search has asked each of its
    operators before it ends.
    """

    def __init__(self, options: SearchOptions) -> None:
        super().__init__()
        self._enough = EXPECTED_GAIN[options.effort]
        self._most = options.generations or options.most_generations

    def _update(self, algorithm: Evolution) -> float:
        generations = len(algorithm.history_of_work)
        if generations >= self._most:
            return 1.0
        if generations < 2 * len(algorithm.operators):
            return generations / self._most
        expected = expected_gain(algorithm.history_of_work, len(algorithm.operators))
        return 1.0 if expected < self._enough else generations / self._most


def expected_gain(history: Sequence[tuple[float, float]], operators: int) -> float:
    """What a further second brings, from seconds and gain of each generation so far.

    A second has at least as many generations as there are operators: where designs are large one takes longer, and
    what a single operator brought says nothing about the others.
    """
    found = [0.0, 0.0]
    spent, number, place = 0.0, 0, 0
    for seconds, gain in reversed(history):
        if spent >= place + 1.0 and number >= (place + 1) * operators:
            place += 1
        if place > 1:
            break
        found[place] += gain
        spent, number = spent + seconds, number + 1
    if spent < 1.0 and len(history) < 50:
        return np.inf  # too little was done to say
    return max(found[0], 0.5 * found[1])


def evolution(population: DesignPopulation, first: FloatArray) -> Evolution:
    """The search of a problem from a first generation (b, m, g), ready to go on."""
    problem = population.design_problem
    number, names = population.n_obj, population.wanted.names
    weights = np.array([WEIGHTS.get(name, 0.0) for name in names])
    if number == 1:
        weights[0] = WEIGHTS["total"]
    archive = Archive(first.shape[1:], number, weights)
    state = State(population, archive, np.random.default_rng([problem.optimiser.seed, 1]))
    found = Evolution(state, first)
    found.setup(population, termination=ExpectedGain(problem.optimiser), seed=problem.optimiser.seed)
    return found
