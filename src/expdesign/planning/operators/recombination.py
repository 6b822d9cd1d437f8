"""Variation of designs: real and discrete decision variables in one vector, and measurements as units.

Simulated binary crossover and polynomial mutation are pymoo's; what is added is what they do not know: that some
variables are indices, and that the order of the measurements means nothing.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from pymoo.core.crossover import Crossover
from pymoo.core.mutation import Mutation
from pymoo.core.population import Population
from pymoo.core.repair import Repair
from pymoo.operators.crossover.sbx import SBX
from pymoo.operators.mutation.pm import PM

from expdesign.arrays import FloatArray
from expdesign.planning.operators.exchange import bred
from expdesign.planning.operators.operator import State
from expdesign.planning.space import DesignSpace


class DesignCrossover(Crossover):  # type: ignore[misc]
    """SBX on continuous decisions, exchange on discrete ones, and now and then exchange of whole measurements."""

    def __init__(self, space: DesignSpace, exchange: float = 0.3) -> None:
        super().__init__(2, 2)
        self._space = space
        self._exchange = exchange
        self._sbx = SBX(eta=15, prob=1.0, prob_var=0.9)

    def _do(self, problem: Any, X: FloatArray, *args: Any, random_state: Any = None, **kwargs: Any) -> FloatArray:
        space, generator = self._space, random_state
        children = np.asarray(self._sbx._do(problem, X.copy(), *args, random_state=generator, **kwargs)).copy()
        count = X.shape[1]
        shape = (count, space.measurements, space.decisions)
        parents = [X[i].reshape(shape) for i in (0, 1)]
        swap_gene = generator.random(shape) < 0.5
        mixed = [np.where(swap_gene, parents[1 - i], parents[i]) for i in (0, 1)]
        swap_row = generator.random((count, space.measurements, 1)) < 0.5
        rows = [np.where(swap_row, parents[1 - i], parents[i]) for i in (0, 1)]
        whole = (generator.random(count) < self._exchange)[:, None, None]
        for i in (0, 1):
            child = np.where(space.discrete, mixed[i], children[i].reshape(shape))
            children[i] = np.where(whole, rows[i], child).reshape(count, -1)
        return children


class DesignMutation(Mutation):  # type: ignore[misc]
    """Polynomial mutation on continuous decisions; a discrete decision is drawn anew, or moved to a neighbour.

    With `merge`, now and then a measurement is moved to the pose of another one of its design, so that both share one
    unloaded measurement: poses that come close by chance do not become equal.
    """

    def __init__(self, space: DesignSpace, *, merge: bool = False) -> None:
        super().__init__()
        self._space = space
        self._merge = 0.2 if merge and space.measurements > 1 else 0.0
        self._rate = min(1.0, 1.5 / max(1, space.measurements * space.decisions))
        self._polynomial = PM(eta=20, prob=1.0, prob_var=self._rate)

    def _do(self, problem: Any, X: FloatArray, *args: Any, random_state: Any = None, **kwargs: Any) -> FloatArray:
        space, generator = self._space, random_state
        moved = np.asarray(self._polynomial._do(problem, X.copy(), *args, random_state=generator, **kwargs))
        shape = (len(X), space.measurements, space.decisions)
        current = X.reshape(shape)
        uniform = generator.random(shape)
        drawn = np.minimum(np.floor(uniform * (space.upper + 1.0)), space.upper)
        step = np.where(generator.random(shape) < 0.5, -1.0, 1.0)
        neighbour = np.clip(np.rint(current) + step, space.lower, space.upper)
        changed = np.where(generator.random(shape) < 0.5, drawn, neighbour)
        discrete = np.where(generator.random(shape) < self._rate, changed, current)
        mutated: FloatArray = np.where(space.discrete, discrete, moved.reshape(shape))
        if self._merge:
            chosen = np.flatnonzero(generator.random(len(X)) < self._merge)
            to, of = generator.integers(space.measurements, size=(2, len(chosen)))
            mutated[chosen, to] = np.where(space.of_pose, mutated[chosen, of], mutated[chosen, to])
        return mutated.reshape(len(X), -1)


class CanonicalOrder(Repair):  # type: ignore[misc]
    """Sorts the measurements of each design, so that permutations of one design are recognised as duplicates."""

    def __init__(self, space: DesignSpace) -> None:
        super().__init__()
        self._space = space

    def _do(self, problem: Any, X: FloatArray, **kwargs: Any) -> FloatArray:
        decisions = X.reshape(len(X), self._space.measurements, self._space.decisions)
        return self._space.canonical(decisions).reshape(len(X), -1)


class Recombination:
    """NSGA-II's own variation of its survivors (`mate`, of so many); and children of neighbours in the sense of the
    front, which descend: a memetic algorithm (Moscato 1989) in which every aim has parents of its own (MOEA/D, Zhang &
    Li 2007).
    """

    name = "recombination"

    def __init__(self, mate: Callable[[int], Population]) -> None:
        self._mate = mate

    def offspring(self, state: State) -> FloatArray:
        drawn = self._mate(state.options.population // 2)
        designs = state.population.decisions(drawn.get("X").astype(float))
        if not state.smooth:
            return designs
        aims = state.aims(state.options.aims)
        of = np.repeat(np.arange(len(aims)), state.children(aims))
        children = state.descended(bred(state, aims, of), aims[of], state.options.brief)
        return np.concatenate([designs, children])
