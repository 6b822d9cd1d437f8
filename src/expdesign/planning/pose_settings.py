"""Which measurements of a design are taken, and which of them share a setting of the robot.

A measurement has one decision more where that has to be chosen: the number of the setting of its pose. Measurements
with the same pose and setting are one series, with one unloaded reference where references are shared; the same pose
may be set anew, with a reference of its own and the cost of a change. Where a budget leaves open how many measurements
there are, a measurement may be left out.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.planning.budget import Budget

LEFT_OUT = -1
"""The setting of a measurement that is not taken."""
NEAR = 1e-3
"""Part of a coordinate's range by which poses differ at least: a change of pose that brings less is not worth the
time, and what the criteria lose is of the second order."""
_STEPS = 1.5
"""Steps of what can be set by which poses differ at least."""


@dataclass(frozen=True)
class PoseSettings:
    """The decision about settings.

    Attributes:
        gene: its place among the decisions of a measurement.
        poses: decisions of the pose itself, shape (g,).
        near: how near two poses are one, for each decision, shape (g,).
        shared: whether measurements of one setting share a reference, so that the number of the setting counts.
        budget: of the plan's time; None where all measurements are taken.
        kept: decisions that have to occur, NaN where they do not matter, (g,) each.
    """

    gene: int
    poses: BoolArray
    near: FloatArray
    shared: bool
    budget: Budget | None
    kept: tuple[FloatArray, ...] = ()

    @property
    def first(self) -> float:
        """The decision for the first setting of a pose."""
        return 0.0 if self.budget is None else 1.0

    def taken(self, decisions: FloatArray) -> BoolArray:
        """Which measurements (..., g) are taken."""
        found: BoolArray = decisions[..., self.gene] >= self.first
        return found

    def arranged(self, decisions: FloatArray) -> FloatArray:
        """Designs (b, m, g) with one pose for those that are near, within the budget, and settings numbered by the
        order of what is measured in them.
        """
        designs = self._joined(decisions)
        if self.budget is not None:
            designs = self._afforded(designs, self.budget)
        return self._numbered(designs) if self.shared else designs

    def closed(self, designs: FloatArray) -> FloatArray:
        """Sorted designs (..., m, g) with those that are left out at the end, as copies of the first measurement, so
        that nothing of them counts.
        """
        if self.budget is None:
            return designs
        order = np.argsort(~self.taken(designs), axis=-1, kind="stable")
        found = np.take_along_axis(designs, order[..., None], axis=-2)
        copied = np.repeat(found[..., :1, :], found.shape[-2], axis=-2)
        copied[..., self.gene] = 0.0
        return np.where(self.taken(found)[..., None], found, copied)

    def units(self, designs: FloatArray) -> BoolArray:
        """Which measurements of designs (..., m, g) are the first of their setting, shape (..., m)."""
        same = self._same(designs)
        first: BoolArray = ~np.tril(same, -1).any(axis=-1) & self.taken(designs)
        return first

    def minutes(self, designs: FloatArray) -> FloatArray:
        """What plans of designs (..., m, g) take (min), shape (...)."""
        assert self.budget is not None
        again = self._again(designs).sum(axis=-1)
        return self.budget.minutes_of(self.taken(designs).sum(axis=-1), self.units(designs).sum(axis=-1), again)

    def affordable(self, others: FloatArray, added: FloatArray) -> BoolArray:
        """Whether designs (b, m − 1, g) may have one of some measurements (b, l, g), or (1, l, g), as well, (b, l)."""
        if self.budget is None:
            return np.ones((1, added.shape[1]), dtype=bool)
        where, there, taken = self._where, self.taken(others), self.taken(added)
        known = (others[:, None][..., where] == added[:, :, None][..., where]).all(axis=-1) & there[:, None]
        count = there.sum(axis=1)[:, None] + taken
        repeats = ((others[:, None] == added[:, :, None]).all(axis=-1) & there[:, None]).any(axis=-1) & taken
        again = self._again(others).sum(axis=-1)[:, None] + repeats
        units = self.units(others).sum(axis=1)[:, None] + (taken & ~known.any(axis=-1))
        poses = self.budget.poses or np.inf
        within: BoolArray = (self.budget.minutes_of(count, units, again) <= self.budget.minutes) & (units <= poses)
        return within & (count >= self.budget.least.measurements)

    def _again(self, designs: FloatArray) -> BoolArray:
        """Which measurements of designs (..., m, g) repeat an earlier one, pose, setting and load, shape (..., m)."""
        same = (designs[..., :, None, :] == designs[..., None, :, :]).all(axis=-1)
        taken = self.taken(designs)
        again: BoolArray = (np.tril(same, -1) & taken[..., None, :]).any(axis=-1) & taken
        return again

    @property
    def _where(self) -> BoolArray:
        """Decisions that tell settings apart."""
        found = self.poses.copy()
        found[self.gene] = self.shared
        return found

    def _same(self, designs: FloatArray) -> BoolArray:
        """Which two measurements of designs (..., m, g) are taken at one setting, shape (..., m, m)."""
        where, taken = designs[..., self._where], self.taken(designs)
        same: BoolArray = (where[..., :, None, :] == where[..., None, :, :]).all(axis=-1)
        return same & taken[..., :, None] & taken[..., None, :]

    def _joined(self, designs: FloatArray) -> FloatArray:
        """Poses that are near each other become the first of them, each series with a setting of its own."""
        poses = designs[..., self.poses]
        apart = np.abs(poses[:, :, None] - poses[:, None])
        close = (apart <= self.near[self.poses]).all(axis=-1) & (apart > 0.0).any(axis=-1)
        found = designs.copy()
        for place in np.flatnonzero(np.logical_or.reduce(close, axis=(1, 2))):
            design = found[place]
            _, code = np.unique(design[:, self._where], axis=0, return_inverse=True)
            kept: list[int] = []
            for row in range(len(design)):
                near = [k for k in kept if (np.abs(poses[place, row] - poses[place, k]) <= self.near[self.poses]).all()]
                if near:
                    design[row, self.poses] = poses[place, near[0]]
                else:
                    kept.append(row)
            if self.shared:
                taken = self.taken(design)
                design[taken, self.gene] = self.first + code.ravel()[taken]
        return found

    def _afforded(self, designs: FloatArray, budget: Budget) -> FloatArray:
        """Designs within the budget: settings are joined, the nearest first, and measurements left out from the last
        on, so that there are as many measurements to a setting as before.
        """
        found = designs.copy()
        least = budget.least.measurements
        for design in found[self.taken(found).sum(axis=1) < least]:
            design[np.flatnonzero(~self.taken(design))[: least - int(self.taken(design).sum())], self.gene] = self.first
        over = self.minutes(found) > budget.minutes + 1e-9
        if budget.poses is not None:
            over |= self.units(found).sum(axis=1) > budget.poses
        for place in np.flatnonzero(over):
            self._fit(found[place], budget)
        return found

    def _fit(self, design: FloatArray, budget: Budget) -> None:
        """Change a design (m, g) until it is within the budget."""
        most = len(design) if budget.poses is None else budget.poses
        fewest, least = max(1, budget.least.poses), budget.least.measurements
        wanted = self.units(design).sum() / self.taken(design).sum()
        while True:
            taken, units = self.taken(design), self.units(design)
            count, number = int(taken.sum()), int(units.sum())
            if number <= most and float(self.minutes(design)) <= budget.minutes + 1e-9:
                return
            if number > fewest and (number > min(most, wanted * count) or count <= least):
                self._join_nearest(design, np.flatnonzero(units))
            elif count > least:
                free = [row for row in np.flatnonzero(taken)[::-1] if not self._demanded(design[row])]
                design[free[0] if free else int(np.flatnonzero(taken)[-1]), self.gene] = 0.0
            else:
                return

    def _join_nearest(self, design: FloatArray, units: IntArray) -> None:
        """Two settings of a design (m, g), whose first measurements are given, become one."""
        span = np.where(self.near > 0.0, self.near, 1.0)
        poses = (design[units] / span)[:, self.poses]
        distance = ((poses[:, None] - poses[None]) ** 2).sum(axis=-1)
        fixed = np.array([self._demanded(design[unit]) for unit in units])
        distance[fixed[:, None] & fixed] = np.inf
        np.fill_diagonal(distance, np.inf)
        first, second = divmod(int(np.argmin(distance)), len(units))
        if fixed[second]:
            first, second = second, first
        where = self._where
        moved = (design[:, where] == design[units[second], where]).all(axis=1) & self.taken(design)
        design[np.ix_(moved, where)] = design[units[first], where]

    def _demanded(self, measurement: FloatArray) -> bool:
        """Whether a measurement (g,) is one that has to occur."""
        return any(bool((np.isnan(wanted) | (measurement == wanted)).all()) for wanted in self.kept)

    def _numbered(self, designs: FloatArray) -> FloatArray:
        """Designs (b, m, g) whose settings of a pose are numbered from the first on, by their least measurement."""
        order = np.argsort(np.zeros(designs.shape[:2]), axis=1, kind="stable")
        columns = [
            *np.flatnonzero(self.poses),
            *np.flatnonzero(~self.poses & (np.arange(len(self.poses)) != self.gene)),
        ]
        for column in reversed(columns):
            values = np.take_along_axis(designs[..., column], order, axis=1)
            order = np.take_along_axis(order, np.argsort(values, axis=1, kind="stable"), axis=1)
        found = np.take_along_axis(designs, order[..., None], axis=1)
        taken, same = self.taken(found), self._same(found)
        first = ~np.tril(same, -1).any(axis=2) & taken
        begin = np.where(taken, same.argmax(axis=2), np.arange(found.shape[1]))
        poses = found[..., self.poses]
        at_one = (poses[:, :, None] == poses[:, None]).all(axis=3)
        earlier = np.arange(found.shape[1])[None, None] < begin[:, :, None]
        number = (at_one & first[:, None] & earlier).sum(axis=2)
        found[..., self.gene] = np.where(taken, self.first + number, found[..., self.gene])
        return found


def nearness(steps: FloatArray, lower: FloatArray, upper: FloatArray, poses: BoolArray) -> FloatArray:
    """How near two poses are one, for each decision (g,): `NEAR` of its range, and no less than a step or two."""
    return np.where(poses & (steps > 0.0), np.maximum(NEAR * (upper - lower), _STEPS * steps), 0.0)
