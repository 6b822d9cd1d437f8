"""The designs that no other one dominates, and the best of each criterion, without a limit to their number."""

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.planning.front import hypervolume, non_dominated, reference_point

WEIGHTS = {"total": 10.0, "duir": 1.0}
"""What a share of a criterion's least value counts against the same share of the hypervolume, in which the recommended
plan and the least DUIR hardly show: a search ends where a turn brings 0.1 % of the one and 0.01 % of `total`."""


class Archive:
    """Designs that are kept beside the population of a search.

    Args:
        shape: m and g of a design.
        objectives: number of criteria that span the front.
        names: of the criteria; those behind the objectives are kept at their least alone.

    Attributes:
        designs: shape (d, m, g).
        values: of the criteria, minimised, shape (d, k).
        objectives: see above.
    """

    def __init__(self, shape: tuple[int, int], objectives: int, names: tuple[str, ...]) -> None:
        self.designs: FloatArray = np.zeros((0, *shape))
        self.values: FloatArray = np.zeros((0, len(names)))
        self.objectives = objectives
        self._weights = np.array([WEIGHTS.get(name, 0.0) for name in names])
        if objectives == 1:
            self._weights[0] = WEIGHTS["total"]
        self._before: FloatArray = self.values

    def __len__(self) -> int:
        return len(self.designs)

    @property
    def front(self) -> FloatArray:
        """Objectives (d, k) of the designs that no other one dominates."""
        values = self.values[:, : self.objectives]
        return values[non_dominated(values)] if len(values) else values

    def add(self, designs: FloatArray, values: FloatArray) -> None:
        """Take feasible designs (b, m, g) with criteria (b, k) into account."""
        if len(designs) == 0:
            return
        together, both = np.concatenate([self.designs, designs]), np.concatenate([self.values, values])
        kept = np.unique(np.concatenate([non_dominated(both[:, : self.objectives]), np.argmin(both, axis=0)]))
        self.designs, self.values = together[kept], both[kept]

    def leave_out(self, designs: FloatArray) -> None:
        """Let go of designs (b, m, g), unless they are the best by a criterion or all that there are."""
        given = {design.tobytes() for design in designs}
        drop: BoolArray = np.array([design.tobytes() in given for design in self.designs], dtype=bool)
        drop[np.argmin(self.values, axis=0)] = False
        if not drop.all():
            self.designs, self.values = self.designs[~drop], self.values[~drop]

    def brought(self) -> float:
        """What designs added since this was asked last have brought; 1 where there was none before.

        The share of the hypervolume, and the shares by which the least of each criterion fell by their weights.
        """
        before = self._before
        self._before = self.values
        if len(self.values) == 0 or before is self.values:
            return 0.0
        if len(before) == 0:
            return 1.0
        least, now = before.min(axis=0), self.values.min(axis=0)
        falls = np.clip((least - now) / np.maximum(np.abs(least), 1e-300), 0.0, 1.0)
        gain = float(self._weights @ falls)
        front = self.front
        volume = 0.0 if self.objectives == 1 else hypervolume(front, reference_point(front))
        if volume <= 0.0:
            return gain
        return gain + max(0.0, 1.0 - hypervolume(before[:, : self.objectives], reference_point(front)) / volume)
