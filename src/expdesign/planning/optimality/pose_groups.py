"""Measurements that stay at one pose together while gradients move it: those of one setting of the robot."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.planning.optimality.differentiated import shared_series
from expdesign.planning.problem import DesignProblem


@dataclass(frozen=True)
class PoseGroups:
    """Which measurements of some designs are at one pose.

    Attributes:
        problem: the design problem.
        numbers: of the groups, shape (b, m).
    """

    problem: DesignProblem
    numbers: IntArray

    @classmethod
    def of(cls, problem: DesignProblem, designs: FloatArray) -> "PoseGroups | None":
        """The groups of designs (b, m, g); None where neither references are shared nor poses have a cost."""
        series = shared_series(problem, problem.space.quantities(designs))
        return None if series is None else cls(problem, series)

    def tied(self, steps: FloatArray, index: IntArray) -> FloatArray:
        """Changes of variables (c, m, g) of the designs with these indices (c,), the same for all poses of a group."""
        return np.where(self.problem.space.of_pose, self._mean[index] @ steps, steps)

    @cached_property
    def _mean(self) -> FloatArray:
        """What takes measurements to the means of their groups, shape (b, m, m)."""
        same = (self.numbers[:, :, None] == self.numbers[:, None, :]).astype(float)
        return same / same.sum(axis=2, keepdims=True)

    def apart(self, designs: FloatArray) -> FloatArray:
        """Designs (b, m, g) whose groups keep references of their own also where they meet at one pose."""
        settings = self.problem.space.settings
        if settings is None or not settings.shared:
            return designs
        found = designs.copy()
        own = settings.first + self.numbers - 1.0
        found[..., settings.gene] = np.where(self.numbers > 0, own, designs[..., settings.gene])
        return found
