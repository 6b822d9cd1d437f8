"""Exchange of measurements within a list of candidates (Fedorov 1972), and the rounding of weights that it starts from.

What a plan is worth depends on its measurements, or series, through sums alone (`additive.py`).
"""

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.design.optimality.additive import additive
from expdesign.design.problem import DesignProblem

_SWEEPS = 50


def rounded(weights: FloatArray, count: int, draws: int, generator: np.random.Generator) -> IntArray:
    """Draws (draws, count) of candidates, each as often as its weight says give or take one (systematic sampling)."""
    support = np.flatnonzero(weights > 0.0)
    order = np.argsort(generator.random((draws, len(support))), axis=1)
    edges = np.cumsum(weights[support][order] / weights.sum(), axis=1)
    points = (np.arange(count) + generator.random((draws, 1))) / count
    places = (points[:, :, None] > edges[:, None, :]).sum(axis=2)
    chosen: IntArray = support[np.take_along_axis(order, np.minimum(places, len(support) - 1), axis=1)]
    return chosen


class Exchange:
    """Exchange of measurements within a list of candidates.

    Args:
        problem: the design problem.
        variables: candidates, shape (j, g).
        factor: s, of the load errors.
    """

    def __init__(self, problem: DesignProblem, variables: FloatArray, factor: float) -> None:
        self._sums = additive(problem, factor)
        self._parts: FloatArray = self._sums.parts(variables)
        self._poses: FloatArray = variables[:, problem.space.of_pose]

    def sums(self, plans: IntArray) -> FloatArray:
        """Sums (b, c) over the measurements of plans (b, m)."""
        return self._sums.sums(self._parts[plans], self._poses[plans])

    def values(self, sums: FloatArray) -> FloatArray:
        """DUIR² + s²·FEIR² (...,) of plans with the given sums (..., c); inf where they identify too little."""
        noise, force = self._sums.variances(sums)
        largest = (noise + force).max(axis=-1)
        result: FloatArray = np.where((largest > 0.0) & np.isfinite(largest), largest, np.inf)
        return result

    def best(self, plans: IntArray, count: int) -> IntArray:
        """The best `count` of plans (b, m), without repetitions."""
        plans = np.unique(np.sort(plans, axis=1), axis=0)
        values = self.values(self.sums(plans))
        return plans[np.argsort(values, kind="stable")[:count]]

    def improve(self, plans: IntArray) -> IntArray:
        """Plans (b, m) after exchanges that help, one measurement at a time, until none does (Fedorov 1972)."""
        plans = plans.copy()
        for plan in plans:
            value = float(self.values(self.sums(plan[None]))[0])
            for _ in range(_SWEEPS):
                before = value
                for place in range(len(plan)):
                    rest = np.delete(plan, place)[None]
                    options = self._sums.joined(
                        self._parts[rest], self._poses[rest], self._parts[None], self._poses[None]
                    )
                    found = self.values(options[0])
                    winner = int(np.argmin(found))
                    if found[winner] < value * (1.0 - 1e-10):
                        plan[place], value = winner, float(found[winner])
                if value >= before * (1.0 - 1e-9):
                    break
        return plans
