"""Exchange of two measurements at once, and plans of one or two measurements that are repeated (theory.md 15)."""

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.planning.operators.children import bred
from expdesign.planning.operators.state import AIMS, BRIEF_STEPS, State
from expdesign.planning.sampling import extreme_measurements
from expdesign.planning.scalarisation import Aims


class PairExchange:
    """Exchanges two measurements at once, of children of the designs that are best by one criterion alone: what is
    least there, exchanges of single ones miss most. With them, plans of one or two measurements that are repeated.
    """

    name = "pairs"

    def propose(self, state: State) -> FloatArray:
        ends = state.ends()
        aims = ends.joined(state.along(max(2, AIMS // 2)))
        found, places = self._repeated(state, aims)
        problem, m = state.problem, state.problem.space.measurements
        if m > 1 and problem.space.settings is None:
            of = np.repeat(np.arange(len(ends)), state.children(ends) // 2)
            children = bred(state, ends, of)
            drawn = np.argsort(state.generator.random((len(children), 3, m)), axis=2)[..., :2]
            offered = np.concatenate([state.library, state.stock])
            children = state.exchange.pairs(children, ends[of], drawn, offered)
            if state.gridded:
                children = state.exchange.singles(children, ends[of], state.library[:20], varied=True)
            found, places = np.concatenate([found, children]), np.concatenate([places, of])
        return state.descended(found, aims[places], BRIEF_STEPS)

    @staticmethod
    def _repeated(state: State, aims: Aims) -> tuple[FloatArray, IntArray]:
        """Plans of repeated measurements not much farther from their aims than the best known, one for each."""
        problem = state.problem
        if not repetitions_count(state):
            return np.zeros((0, problem.space.measurements, problem.space.decisions)), np.zeros(0, dtype=np.int64)
        share = float(state.generator.choice((0.5, 0.8)))
        drawn = extreme_measurements(problem, 500, share, state.generator)
        found, of, scores = state.exchange.repeated(drawn, aims, 1, 60)
        order = np.lexsort((scores, of))
        first = order[np.unique(of[order], return_index=True)[1]]
        known = aims.scores(state.archive.values).min(axis=1)
        kept = first[scores[first] < known[of[first]] + 0.25]
        return found[kept], of[kept]


def repetitions_count(state: State) -> bool:
    """Whether repeated measurements are worth looking at: where load errors count, and nothing else is asked of a plan
    than that its measurements can be taken.
    """
    return (
        bool(state.problem.loaded.sources)
        and state.sums
        and state.problem.constraints is None
        and state.problem.budget is None
    )
