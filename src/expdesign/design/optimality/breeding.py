"""New valleys from known ones: designs that share out the measurements of the best, aim by aim.

DUIR is nearly convex in what the relaxation chooses; FEIR is far from it, and what exchanges or descents find is the
valley that happens to be near. Here the best designs of many valleys are kept for every aim along the front, neighbours
in the sense of the front exchange measurements, and their children descend: a memetic algorithm (Moscato 1989) in which
every aim has parents of its own (MOEA/D, Zhang & Li 2007).
"""

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.design.optimality.neighbours import Neighbours
from expdesign.design.optimality.objectives import achieved
from expdesign.design.optimality.variants import variants

_ELITE = 12
"""Parents of an aim."""
_DISTINCT = 1e-4
"""Difference in an aim below which two designs count as one valley."""


class Breeding:
    """The best designs of each aim, and their children.

    Args:
        neighbours: of designs, for what is varied.
        generator: of what is drawn.
        shape: m, g and the number of criteria k.
    """

    def __init__(self, neighbours: Neighbours, generator: np.random.Generator, shape: tuple[int, int, int]) -> None:
        self._neighbours, self._generator = neighbours, generator
        self._designs: FloatArray = np.zeros((0, *shape[:2]))
        self._values: FloatArray = np.zeros((0, shape[2]))

    def learn(self, designs: FloatArray, values: FloatArray) -> None:
        """Keep designs (d, m, g) with criteria (d, k)."""
        self._designs = np.concatenate([self._designs, designs])
        self._values = np.concatenate([self._values, values])

    def children(self, centres: FloatArray, weights: FloatArray, aims: IntArray) -> FloatArray:
        """One child (c, m, g) for each entry of `aims` (c,), sorted, which are among those with centres and weights
        (b, k).

        A third has one measurement of a parent replaced by one of another, a third is mixed from two parents, and a
        third has one variable of one measurement changed where any is discrete.
        """
        found = []
        for aim, count in zip(*np.unique(aims, return_counts=True), strict=True):
            elite = self._elite(centres[aim], weights[aim])
            found.append(self._bred(self._designs[elite], int(count)))
        return np.concatenate(found)

    def best(self, centres: FloatArray, weights: FloatArray) -> FloatArray:
        """The best design (b, m, g) of each aim."""
        scores = achieved(self._values[None], centres[:, None], weights[:, None])
        best: FloatArray = self._designs[scores.argmin(axis=1)]
        return best

    def least(self, centres: FloatArray, weights: FloatArray) -> FloatArray:
        """How far the best design of each aim is from it, shape (b,)."""
        found: FloatArray = achieved(self._values[None], centres[:, None], weights[:, None]).min(axis=1)
        return found

    def _elite(self, centre: FloatArray, weight: FloatArray) -> IntArray:
        score = achieved(self._values, centre, weight)
        order = np.argsort(score, kind="stable")
        return order[np.diff(score[order], prepend=-np.inf) > _DISTINCT][:_ELITE]

    def _bred(self, elite: FloatArray, count: int) -> FloatArray:
        draw, (number, m, g) = self._generator.integers, elite.shape
        children = elite[draw(number, size=count)]
        rows, place = np.arange(count), draw(m, size=count)
        others = elite.reshape(-1, g)[draw(number * m, size=count)]
        if self._neighbours.discrete:
            varied = variants(self._neighbours.problem, children)[rows, place]
            own = varied[rows, draw(varied.shape[1], size=count)]
            others = np.where((rows % 3 == 2)[:, None], own, others)
        children[rows, place] = others
        mixed = (self._generator.random((count, m)) < 0.5) & (rows % 3 == 1)[:, None]
        return np.where(mixed[..., None], elite[draw(number, size=count)], children)
