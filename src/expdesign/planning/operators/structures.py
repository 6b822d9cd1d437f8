"""Plans within a budget drawn anew, with about as many settings of the robot as the best one that is known.

What two settings are worth depends on both poses and on the loads there: neither moving one nor exchanging measurements
leads from one pair to another. Restarts do (multistart; Marti, Handbook of Metaheuristics 2003, chapter 12).
"""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.operators.state import ALONG_STEPS, State
from expdesign.planning.start import structured_designs

_DRAWN = 80, 6
"""Plans of each structure, and how many of them are improved."""


class Restarts:
    """Draws plans of a structure like the best one's, exchanges their measurements, and descends."""

    name = "restarts"

    def propose(self, state: State) -> FloatArray:
        ends, settings = state.ends(), state.problem.space.settings
        assert settings is not None
        aim = ends[np.array([state.names.index("total")])]
        count = int(settings.units(state.best(aim)).sum())
        designs = structured_designs(state.problem, state.generator, _DRAWN, range(count - 1, count + 2))
        return state.descended(designs, aim[np.zeros(len(designs), dtype=np.int64)], ALONG_STEPS)
