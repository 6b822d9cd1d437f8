"""pymoo's NSGA-II (Deb et al. 2002) with operators of its own: what makes new designs, how designs are set, and when a
search ends.

    NSGA2(pop_size=..., sampling=first, mating=InTurn(state, operators), repair=Settable(problem),
          termination=LittleGain(archive, least, most), callback=...)

A generation asks one operator, one after the other in turn, so that the same seed gives the same front.
"""

from typing import Any

import numpy as np
from pymoo.core.infill import InfillCriterion
from pymoo.core.population import Population
from pymoo.core.repair import Repair
from pymoo.core.termination import Termination

from expdesign.planning.operators.archive import Archive
from expdesign.planning.operators.state import Operator, State
from expdesign.planning.problem import DesignProblem


class Settable(Repair):  # type: ignore[misc]
    """Designs as they can be set, their measurements sorted, so that permutations of one design are duplicates."""

    def __init__(self, problem: DesignProblem) -> None:
        super().__init__()
        self._problem = problem

    def do(self, problem: Any, pop: Population, **kwargs: Any) -> Population:
        designs = problem.decisions(pop.get("X").astype(float))
        pop.set("X", self._problem.settable(designs).reshape(len(pop), -1))
        return pop


class InTurn(InfillCriterion):  # type: ignore[misc]
    """Asks the operators in turn. One that brought nothing in some turns is left out of some.

    Args:
        state: what the search knows.
        operators: who makes designs.
        patience: turns without any gain after which an operator is left out, and of how many turns then.

    Attributes:
        gains: what each operator brought, asked time by asked time.
        asked: the operator of the present generation, by number; -1 before the first one.
    """

    def __init__(self, state: State, operators: list[Operator], patience: int = 3, **settings: Any) -> None:
        super().__init__(**settings)
        self.operators, self._state, self._patience = operators, state, patience
        self.gains: list[list[float]] = [[] for _ in operators]
        self._left_out = [0 for _ in operators]
        self.asked = -1

    @property
    def name(self) -> str:
        """Of the operator that made the present generation."""
        return self.operators[self.asked].name if self.asked >= 0 else "first designs"

    def do(self, problem: Any, pop: Population, n_offsprings: int, **kwargs: Any) -> Population:
        """New designs of the next operator that makes any; none where no operator does."""
        for _ in range((1 + self._patience) * len(self.operators)):
            self.asked = (self.asked + 1) % len(self.operators)
            if self._left_out[self.asked]:
                self._left_out[self.asked] -= 1
                continue
            designs = self.operators[self.asked].propose(self._state)
            made = Population.new(X=designs.reshape(len(designs), problem.n_var))
            made = self.eliminate_duplicates.do(self.repair(problem, made), pop) if len(made) else made
            if len(made):
                return made
            self.brought(0.0)
        return Population.empty()

    def brought(self, gain: float) -> None:
        """Note what the operator that was asked last brought."""
        own = self.gains[self.asked]
        own.append(gain)
        if len(own) >= self._patience and not any(own[-self._patience :]):
            self._left_out[self.asked] = self._patience

    @property
    def expected(self) -> float:
        """What a further turn brings: what the last one brought, or half of what the one before did.

        Infinite while an operator was not asked twice.
        """
        if any(len(own) < 2 for own in self.gains):
            return np.inf
        return max(sum(own[-1] for own in self.gains), 0.5 * sum(own[-2] for own in self.gains))


class LittleGain(Termination):  # type: ignore[misc]
    """Ends a search of which a further turn of all operators is expected to bring next to nothing.

    Args:
        archive: of the search.
        mating: who is asked in turn.
        least: gain of a turn for which the search goes on.
        most: generations.

    Attributes:
        generations: so far.
        why: what ended the search, in words.
    """

    def __init__(self, archive: Archive, mating: InTurn, least: float, most: int) -> None:
        super().__init__()
        self._archive, self._mating, self._least, self._most = archive, mating, least, most
        self.generations, self.why = 0, "no operator made a design that was new"

    def _update(self, algorithm: Any) -> float:
        gain = self._archive.brought()
        if self._mating.asked < 0:
            return 0.0  # the first designs
        self._mating.brought(gain)
        self.generations += 1
        if self.generations >= self._most:
            self.why = f"the largest number of generations, {self._most}, was reached"
            return 1.0
        if self._mating.expected < self._least:
            self.why = f"a further turn of all operators promised less than {self._least:.2g} of the front"
            return 1.0
        return 0.0
