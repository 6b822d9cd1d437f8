"""Measurements that stay at one pose together while gradients move it: those that share their unloaded reference.

Two such series may want the same pose. They are as good as there one step of what can be set apart, with a reference
each; at the same pose they would be one series with one reference. While poses move, the groups are therefore held, and
in the end those that meet are taken a step apart.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.design.optimality.differentiated import shared_series
from expdesign.design.problem import DesignProblem
from expdesign.instrument.deflection_noise import series_by_pose


@dataclass(frozen=True)
class PoseGroups:
    """Which measurements of some designs are at one pose.

    Attributes:
        problem: the design problem.
        numbers: of the groups, shape (b, m).
        series: the same where measurements of a group share their reference, else None.
    """

    problem: DesignProblem
    numbers: IntArray
    series: IntArray | None

    @classmethod
    def of(cls, problem: DesignProblem, designs: FloatArray) -> "PoseGroups | None":
        """The groups of designs (b, m, g); None where neither references are shared nor distinct poses are few."""
        series = shared_series(problem, problem.space.quantities(designs))
        if series is not None:
            return cls(problem, series, series)
        if problem.space.most_poses is None:
            return None
        return cls(problem, series_by_pose(problem.space.decode(designs)[0]), None)

    def tied(self, steps: FloatArray, index: IntArray) -> FloatArray:
        """Changes of variables (c, m, g) of the designs with these indices (c,), the same for all poses of a group."""
        numbers = self.numbers[index]
        same = (numbers[:, :, None] == numbers[:, None, :]).astype(float)
        mean = same / same.sum(axis=2, keepdims=True)
        return np.where(self.problem.space.of_pose, mean @ steps, steps)

    def apart(self, designs: FloatArray) -> FloatArray:
        """Designs (b, m, g) whose series are at poses of their own where these can be set; those that would be at the
        pose of another are moved inwards, step by step.
        """
        space, pose = self.problem.space, self.problem.space.of_pose
        movable = pose & (space.grid.steps > 0.0)
        if self.series is None or space.most_poses is not None or not movable.any():
            return designs
        rounded = np.where(space.discrete, np.rint(designs), space.grid.nearest(designs))
        at_one = (rounded[:, :, None, pose] == rounded[:, None, :, pose]).all(axis=3)
        together = self.series[:, :, None] == self.series[:, None, :]
        found = designs.copy()
        for place in np.flatnonzero((at_one & ~together).any(axis=(1, 2))):
            taken: set[bytes] = set()
            for number in np.unique(self.series[place]):
                own = np.flatnonzero(self.series[place] == number)
                moved, steps = rounded[place, own[0]], 0
                while moved[pose].tobytes() in taken and steps < len(taken):
                    steps += 1
                    moved = space.inward(rounded[place, own[0]], steps)
                if steps:
                    found[place, own] = np.where(pose, moved, found[place, own])
                taken.add(moved[pose].tobytes())
        return found
