"""Plans of one or two measurements that are repeated (theory.md 15)."""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.operators.state import AIMS, BRIEF_STEPS, State
from expdesign.planning.sampling import extreme_measurements


class RepeatedPlans:
    """Repeats one or two drawn measurements; of each aim the best plan descends where it is not much farther from it
    than the best known.
    """

    name = "repetitions"

    def propose(self, state: State) -> FloatArray:
        aims = state.ends().joined(state.along(AIMS // 2))
        share = float(state.generator.choice((0.5, 0.8)))
        drawn = extreme_measurements(state.problem, 500, share, state.generator)
        found, of, scores = state.exchange.repeated(drawn, aims, 1, 60)
        order = np.lexsort((scores, of))
        first = order[np.unique(of[order], return_index=True)[1]]
        known = aims.scores(state.archive.values).min(axis=1)
        kept = first[scores[first] < known[of[first]] + 0.25]
        return state.descended(found[kept], aims[of[kept]], BRIEF_STEPS)


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
