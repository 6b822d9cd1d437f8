"""The designs that a search keeps: those that no other one dominates, and the best of each criterion."""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.front import hypervolume, non_dominated, reference_point

TOTAL_WEIGHT = 10.0
"""What a share of `total` counts against the same share of the hypervolume: a search ends where a second's work brings
0.1 % of the one and 0.01 % of the other."""


class Archive:
    """Non-dominated designs, without a limit to their number.

    Args:
        shape: m and g of a design.
        objectives: number of criteria that span the front.
        criteria: number of criteria in all, the others being kept at their least alone.

    Attributes:
        designs: shape (d, m, g).
        values: of the criteria, minimised, shape (d, k).
        objectives: see above.
    """

    def __init__(self, shape: tuple[int, int], objectives: int, criteria: int) -> None:
        self.designs: FloatArray = np.zeros((0, *shape))
        self.values: FloatArray = np.zeros((0, criteria))
        self.objectives = objectives

    def __len__(self) -> int:
        return len(self.designs)

    @property
    def front(self) -> FloatArray:
        """Objectives (d, k) of the designs."""
        return self.values[:, : self.objectives]

    def add(self, designs: FloatArray, values: FloatArray) -> float:
        """Take designs (b, m, g) with criteria (b, k) into account; the gain that they bring.

        The gain is the share of the hypervolume, or of the only objective, and `TOTAL_WEIGHT` times the share by which
        the last criterion, `total` as a rule, falls; 1 for the first designs.
        """
        if len(designs) == 0:
            return 0.0
        before = self.values
        together, both = np.concatenate([self.designs, designs]), np.concatenate([self.values, values])
        kept = np.concatenate([non_dominated(both[:, : self.objectives]), np.argmin(both, axis=0)])
        kept = np.unique(kept)
        self.designs, self.values = together[kept], both[kept]
        return 1.0 if len(before) == 0 else self._gain(before)

    def _gain(self, before: FloatArray) -> float:
        least, now = before.min(axis=0), self.values.min(axis=0)
        falls = (least - now) / np.maximum(np.abs(least), 1e-300)
        gain = TOTAL_WEIGHT * float(np.clip(falls[-1], 0.0, 1.0))
        if self.objectives == 1:
            return gain + (TOTAL_WEIGHT * float(np.clip(falls[0], 0.0, 1.0)) if before.shape[1] > 1 else 0.0)
        point = reference_point(self.front[non_dominated(self.front)])
        volume = hypervolume(self.front, point)
        if volume <= 0.0:
            return gain
        return gain + max(0.0, 1.0 - hypervolume(before[:, : self.objectives], point) / volume)
