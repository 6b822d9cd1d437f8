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


@dataclass(frozen=True)
class PoseSettings:
    """The decision about settings.

    Attributes:
        gene: its place among the decisions of a measurement.
        poses: decisions of the pose itself, shape (g,).
        span: range of each decision, shape (g,).
        shared: whether measurements of one setting share a reference, so that the number of the setting counts.
        budget: of the plan's time; None where all measurements are taken.
        kept: decisions that have to occur, NaN where they do not matter, (g,) each.
    """

    gene: int
    poses: BoolArray
    span: FloatArray
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
        """Designs (b, m, g) within the budget, with settings numbered by the order of what is measured in them."""
        designs = decisions if self.budget is None else self._afforded(decisions, self.budget)
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
        return ~self._earlier(designs, self._where) & self.taken(designs)

    def minutes(self, designs: FloatArray) -> FloatArray:
        """What plans of designs (..., m, g) take (min), shape (...)."""
        assert self.budget is not None
        again = self._earlier(designs).sum(axis=-1)
        return self.budget.minutes_of(self.taken(designs).sum(axis=-1), self.units(designs).sum(axis=-1), again)

    def affordable(self, others: FloatArray, added: FloatArray) -> BoolArray:
        """Whether designs (b, m − 1, g) may have one of some measurements (b, l, g), or (1, l, g), as well, (b, l)."""
        if self.budget is None:
            return np.ones((1, added.shape[1]), dtype=bool)
        where, there, taken = self._where, self.taken(others), self.taken(added)
        known = (others[:, None][..., where] == added[:, :, None][..., where]).all(axis=-1) & there[:, None]
        count = there.sum(axis=1)[:, None] + taken
        repeats = ((others[:, None] == added[:, :, None]).all(axis=-1) & there[:, None]).any(axis=-1) & taken
        again = self._earlier(others).sum(axis=-1)[:, None] + repeats
        units = self.units(others).sum(axis=1)[:, None] + (taken & ~known.any(axis=-1))
        poses = self.budget.poses or np.inf
        within: BoolArray = (self.budget.minutes_of(count, units, again) <= self.budget.minutes) & (units <= poses)
        return within & (count >= self.budget.least)

    @property
    def _where(self) -> BoolArray:
        """Decisions that tell settings apart."""
        found = self.poses.copy()
        found[self.gene] = self.shared
        return found

    def _same(self, designs: FloatArray, where: BoolArray | slice = slice(None)) -> BoolArray:
        """Which two measurements of designs (..., m, g) are both taken and equal, in some decisions or in all of them,
        shape (..., m, m).
        """
        some, taken = designs[..., where], self.taken(designs)
        same: BoolArray = (some[..., :, None, :] == some[..., None, :, :]).all(axis=-1)
        return same & taken[..., :, None] & taken[..., None, :]

    def _earlier(self, designs: FloatArray, where: BoolArray | slice = slice(None)) -> BoolArray:
        """Which measurements of designs (..., m, g) repeat an earlier one in this sense, shape (..., m)."""
        earlier: BoolArray = np.logical_or.reduce(np.tril(self._same(designs, where), -1), axis=-1)
        return earlier

    def _afforded(self, designs: FloatArray, budget: Budget) -> FloatArray:
        """Designs within the budget: settings are joined, the nearest first, and measurements left out from the last
        on, so that there are as many measurements to a setting as before.
        """
        found = designs.copy()
        least = budget.least
        for place in np.flatnonzero(self.taken(found).sum(axis=1) < least):
            left_out = np.flatnonzero(~self.taken(found[place]))
            found[place, left_out[: least - len(found[place]) + len(left_out)], self.gene] = self.first
        over = self.minutes(found) > budget.minutes + 1e-9
        if budget.poses is not None:
            over |= self.units(found).sum(axis=1) > budget.poses
        for place in np.flatnonzero(over):
            self._fit(found[place], budget)
        return found

    def _fit(self, design: FloatArray, budget: Budget) -> None:
        """Change a design (m, g) until it is within the budget."""
        most = len(design) if budget.poses is None else budget.poses
        fewest, least = budget.least_poses, budget.least
        wanted = self.units(design).sum() / self.taken(design).sum()
        while True:
            taken, units = self.taken(design), self.units(design)
            count, number = int(taken.sum()), int(units.sum())
            if number <= most and float(self.minutes(design)) <= budget.minutes + 1e-9:
                return
            fewer = number > fewest and (number > min(most, wanted * count) or count <= least)
            if fewer and self._join_nearest(design, np.flatnonzero(units)):
                continue
            if count > least:
                free = [row for row in np.flatnonzero(taken)[::-1] if not _is_one(design[row], self.kept)]
                design[free[0] if free else int(np.flatnonzero(taken)[-1]), self.gene] = 0.0
            else:
                return

    def _join_nearest(self, design: FloatArray, units: IntArray) -> bool:
        """Two settings of a design (m, g), whose first measurements are given, become one, where any two may.

        A demanded pose stays where it is; a demanded load may be measured at any.
        """
        poses = (design[units] / self.span)[:, self.poses]
        distance = ((poses[:, None] - poses[None]) ** 2).sum(axis=-1)
        placed = tuple(wanted for wanted in self.kept if not np.isnan(wanted[self.poses]).all())
        fixed = np.array([_is_one(design[unit], placed) for unit in units])
        distance[fixed[:, None] & fixed] = np.inf
        np.fill_diagonal(distance, np.inf)
        if not np.isfinite(distance).any():
            return False
        first, second = divmod(int(np.argmin(distance)), len(units))
        if fixed[second]:
            first, second = second, first
        where = self._where
        moved = (design[:, where] == design[units[second], where]).all(axis=1) & self.taken(design)
        design[np.ix_(moved, where)] = design[units[first], where]
        return True

    def _numbered(self, designs: FloatArray) -> FloatArray:
        """Designs (b, m, g) whose settings of a pose are numbered from the first on, by their least measurement."""
        loads = ~self.poses
        loads[self.gene] = False
        keys = np.concatenate([designs[..., loads][..., ::-1], designs[..., self.poses][..., ::-1]], axis=-1)
        order = np.lexsort(np.moveaxis(keys, -1, 0), axis=-1)
        found = np.take_along_axis(designs, order[..., None], axis=1)
        begun, both = np.cumsum(self.units(found), axis=1), (self._where, self.poses)
        own, first = (np.take_along_axis(begun, self._same(found, some).argmax(axis=2), axis=1) for some in both)
        found[..., self.gene] = np.where(self.taken(found), self.first + own - first, found[..., self.gene])
        return found


def _is_one(measurement: FloatArray, demanded: tuple[FloatArray, ...]) -> bool:
    """Whether a measurement (g,) is one of some that have to occur, in which NaN does not matter."""
    return any(bool((np.isnan(wanted) | (measurement == wanted)).all()) for wanted in demanded)
