"""Recombination of designs: pymoo's own variation of the survivors, as designs that can be set; and children that are
put together of the measurements of parents, which descend.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from pymoo.core.population import Population
from pymoo.core.repair import Repair

from expdesign.arrays import FloatArray
from expdesign.planning.operators.exchange import bred
from expdesign.planning.operators.operator import State
from expdesign.planning.space import DesignSpace


class CanonicalOrder(Repair):  # type: ignore[misc]
    """Rounds indices and steps, and sorts the measurements of each design, so that permutations of one design are
    recognised as duplicates.
    """

    def __init__(self, space: DesignSpace) -> None:
        super().__init__()
        self._space = space

    def _do(self, problem: Any, X: FloatArray, **kwargs: Any) -> FloatArray:
        decisions = X.reshape(len(X), self._space.measurements, self._space.decisions)
        return self._space.canonical(decisions).reshape(len(X), -1)


class Recombination:
    """NSGA-II's own variation of its survivors (`mate`, of so many); and children of neighbours in the sense of the
    front, which descend where gradients are known: a memetic algorithm (Moscato 1989) in which every aim has parents of
    its own (MOEA/D, Zhang & Li 2007).
    """

    name = "recombination"

    def __init__(self, mate: Callable[[int], Population]) -> None:
        self._mate = mate

    def offspring(self, state: State) -> FloatArray:
        drawn = self._mate(state.options.population // 2)
        designs = state.population.decisions(drawn.get("X").astype(float))
        aims = state.aims(state.options.aims)
        of = np.repeat(np.arange(len(aims)), state.children(aims))
        children = state.descended(bred(state, aims, of), aims[of], state.options.brief)
        return np.concatenate([designs, children])
