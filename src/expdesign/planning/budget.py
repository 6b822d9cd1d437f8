"""A budget of time in place of a number of measurements (`experiment.budget`).

How long a plan takes at most depends on three numbers alone: m measurements at p settings of the robot, of which some
repeat the load of another one there. Which measurements are taken, and which share a setting, the search decides
(`pose_settings.py`).

How long a plan takes, in the order of the laboratory sheet, is told without looking for that order. With deflections,
whatever is measured at one pose stands together, and the number of changes does not depend on the order of the poses: p
changes of the pose; without shared references 2m readings and 2m − 1 changes of the load (on and off around every
unloaded reading); with them one more reading for every series, and in every series its distinct loads, with the load
taken off between series, each of which is a setting of the robot. Absolute poses are put in order by
`laboratory_sheet.ordered` where both poses and loads vary.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.planning.schema import BudgetSection, ConstraintsSection, CostsSection, ExperimentSection

LARGEST = 200
"""Measurements beyond which a budget alone does not decide."""


@dataclass(frozen=True)
class Budget:
    """What measuring may cost.

    Attributes:
        minutes: in all.
        costs: of changes and readings (min).
        referenced: whether deflections are measured, which need references without load.
        shared: whether measurements at one pose share their reference.
        validation: rows at poses of their own that are measured as well.
        least: measurements that there have to be.
        least_poses: different poses that there have to be.
        most: measurements that there may be, or None.
        poses: distinct poses that there may be, or None.
    """

    minutes: float
    costs: CostsSection
    referenced: bool
    shared: bool
    validation: int = 0
    least: int = 1
    least_poses: int = 1
    most: int | None = None
    poses: int | None = None

    def minutes_of(
        self, measurements: IntArray | int, settings: IntArray | int, again: IntArray | int = 0
    ) -> FloatArray:
        """Minutes that no plan of so many measurements at so many settings exceeds, with its rows for validation; of
        them `again` repeat the load of another one in its setting.
        """
        m, p = np.asarray(measurements) + self.validation, np.asarray(settings) + self.validation
        if not self.referenced:  # pose by pose, with another load before every reading
            return self.costs.minutes(p, m - again, m)
        if self.shared:
            return self.costs.minutes(p, m + p - 1 - again, m + p)
        return self.costs.minutes(p, 2 * m - 1, 2 * m)  # every reading has an unloaded one beside it

    @property
    def largest(self) -> int:
        """The most measurements that fit; more than `LARGEST` are not counted; 0 where nothing fits."""
        limit = LARGEST + 1 if self.most is None else self.most
        if self.poses is not None and self.poses < self.least_poses:
            return 0
        counts = np.arange(1, limit + 1)
        fit = counts[(self.minutes_of(counts, self.least_poses) <= self.minutes) & (counts >= self.least)]
        return int(fit.max(initial=0))


def read_budget(experiment: ExperimentSection, referenced: bool) -> Budget | None:
    """The budget, or None where there is a number of measurements.

    Args:
        experiment: as configured.
        referenced: whether deflections are measured, which need references without load.

    Raises:
        InputError: neither a budget nor a number is given, costs are missing, or not one measurement fits.
    """
    section, costs = experiment.budget, experiment.costs
    if section is None:
        if experiment.measurements is None:
            raise experiment.where("measurements").fault("the key is missing", "Add it, or a `budget` with `costs`.")
        return None
    if costs is None or not costs.known:
        what = "a budget says nothing where measuring costs nothing"
        remedy = "Add `experiment.costs`, e.g. `{pose_change: 2, mass_change: 10, reading: 0.5}` (min)."
        raise section.where().fault(what, remedy)
    if experiment.reference_pose is not None:
        what = "with a reference pose every pose stands between references, which a budget does not count"
        raise section.where().fault(what, "Give a number of `measurements`.")
    demanded = experiment.constraints or ConstraintsSection()
    poses = max(demanded.distinct_poses, len(demanded.poses))
    budget = Budget(
        minutes=section.minutes,
        costs=costs,
        referenced=referenced,
        shared=experiment.deflection_noise.shared_reference,
        validation=0 if experiment.validation is None else experiment.validation.measurements,
        least=max(poses, demanded.distinct_masses, len(demanded.masses_kg)),
        least_poses=poses,
        most=experiment.measurements,
        poses=section.distinct_poses,
    )
    _require_structure(budget, section)
    return budget


def _require_structure(budget: Budget, section: BudgetSection) -> None:
    place = section.where("minutes")
    if budget.largest:
        if budget.largest > LARGEST and budget.most is None:
            what = f"the budget allows more than {LARGEST} measurements"
            remedy = "Add `experiment.measurements` as the largest number, or a cost of each reading."
            raise place.fault(what, remedy)
        return
    needed = float(budget.minutes_of(budget.least, budget.least_poses))
    limits = [("measurements", budget.most, budget.least), ("distinct_poses", budget.poses, budget.least_poses)]
    for name, limit, wanted in limits:
        if limit is not None and limit < wanted:
            what = f"`{name}` allows {limit}, and `constraints` demand {wanted}"
            raise section.where().fault(what, "Allow more, or demand less.")
    smallest = "one measurement" if budget.least == 1 else f"the {budget.least} measurements demanded"
    more = f" and the {budget.validation} for validation" if budget.validation else ""
    what = f"{budget.minutes:g} min are too little for {smallest}{more}, which takes {needed:g} min by `costs`"
    raise place.fault(what, f"Allow at least {needed:g} min, or correct `costs`.")
