"""Plans of one or two measurements, repeated: where FEIR is often least, and much of a front towards its end.

FEIR is not convex, and no relaxation leads to where it is least. Load errors of their own in every measurement average
out over repetitions of whichever measurement suffers least, so that plans of few distinct measurements are the best,
and among designs at random there are none. Those of measurements drawn at random are valued by sums (`additive.py`).
"""

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.design.optimality.additive import additive
from expdesign.design.optimality.sum_exchange import scores_of
from expdesign.design.problem import DesignProblem
from expdesign.design.start import extreme_measurements

_DRAWN, _PAIRED, _BEST = 1000, 20, 4
"""Measurements drawn and paired, and plans of each kind, among the first designs of a search."""


def repetitions_count(problem: DesignProblem) -> bool:
    """Whether repeated measurements are worth looking at: where load errors count, and nothing else is asked of a plan
    than that its measurements can be taken.
    """
    return bool(problem.loaded.sources) and problem.space.most_poses is None and problem.constraints is None


class Repetitions:
    """Plans of one or two of some measurements drawn at random, and their criteria.

    Args:
        problem: the design problem.
        names: of the criteria, k, of those in `additive.py`.
        drawn: number of measurements that are drawn.
        paired: how many of them are paired with each other.
        share: of their continuous variables that are at ends.
        generator: of what is drawn.
    """

    def __init__(
        self,
        problem: DesignProblem,
        names: tuple[str, ...],
        drawn: int,
        paired: int,
        share: float,
        generator: np.random.Generator,
    ) -> None:
        self._names, self._m = names, problem.space.measurements
        self._sums = additive(problem, 1.0)
        self._drawn = extreme_measurements(problem, drawn, share, generator)
        self._parts: FloatArray = self._sums.parts(self._drawn)
        self._poses: FloatArray = self._drawn[:, problem.space.of_pose]
        self._series = problem.noise.shared_reference
        self._paired = paired

    def best(self, centres: FloatArray, weights: FloatArray, count: int) -> tuple[FloatArray, IntArray, FloatArray]:
        """The best plans (d, m, g) of one measurement, and of two for every number of repetitions of the first, for
        aims with `centres` and `weights` (b, k): `count` each; for which aim (d,) each is, and how far from it (d,).
        """
        scores = self._scores(self._sums.repeated(self._parts, self._m), centres, weights)
        found = [self._least(scores, count, np.arange(len(self._drawn)), np.arange(len(self._drawn)), self._m)]
        # Those that are the least by themselves, and some of all.
        alone = np.unique(scores.argsort(axis=1, kind="stable")[:, : max(1, self._paired // (4 * len(scores)))])
        chosen = np.unique(np.concatenate([alone, np.arange(self._paired)]))
        first, second = (chosen[index].ravel() for index in np.indices((len(chosen), len(chosen))))
        # At one pose the two would share their reference, and be one series.
        if self._series:
            apart = (self._poses[first] != self._poses[second]).any(axis=1)
            first, second = first[apart], second[apart]
        for times in range(1, self._m // 2 + 1):
            one, other = (self._sums.repeated(self._parts, number) for number in (times, self._m - times))
            both = self._scores(one[first] + other[second], centres, weights)
            found.append(self._least(both, count, first, second, times))
        plans, aims, values = (np.concatenate(part) for part in zip(*found, strict=True))
        return plans, aims, values

    def _scores(self, sums: FloatArray, centres: FloatArray, weights: FloatArray) -> FloatArray:
        """How far plans with these sums (d, c) are from aims (b, k), shape (b, d)."""
        return scores_of(self._sums, self._names, sums, centres[:, None], weights[:, None])

    def _least(
        self, scores: FloatArray, count: int, first: IntArray, second: IntArray, times: int
    ) -> tuple[FloatArray, IntArray, FloatArray]:
        best = np.argsort(scores, axis=1, kind="stable")[:, :count]
        aims = np.repeat(np.arange(len(best)), best.shape[1])
        plans = np.where(np.arange(self._m) < times, first[best.ravel(), None], second[best.ravel(), None])
        return self._drawn[plans], aims, scores[aims, best.ravel()]


def repeated_designs(problem: DesignProblem) -> FloatArray:
    """Designs (d, m, g) of one or two measurements, repeated, with the least FEIR and `total` of those drawn."""
    space = problem.space
    if not repetitions_count(problem):
        return np.zeros((0, space.measurements, space.decisions))
    generator = np.random.default_rng([problem.optimiser.seed, 2])
    repetitions = Repetitions(problem, ("feir", "total"), _DRAWN, _PAIRED, 0.5, generator)
    return problem.settable(repetitions.best(np.zeros((2, 2)), np.eye(2), _BEST)[0])
