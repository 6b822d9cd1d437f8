"""A budget of time in place of a number of measurements (`experiment.budget`).

How long a plan takes at most depends on two numbers alone: m measurements at p settings of the robot. Which
measurements are taken, and which share a setting, the search decides (`pose_settings.py`).
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.planning.laboratory_sheet import Costs
from expdesign.planning.measuring_time import most_minutes

LARGEST = 200
"""Measurements beyond which a budget alone does not decide."""


@dataclass(frozen=True)
class Structure:
    """So many measurements at so many settings of the robot."""

    measurements: int
    poses: int


@dataclass(frozen=True)
class Budget:
    """What measuring may cost.

    Attributes:
        minutes: in all.
        costs: of changes and readings (min).
        referenced: whether deflections are measured, which need references without load.
        shared: whether measurements at one pose share their reference.
        validation: rows at poses of their own that are measured as well.
        least: measurements and poses that there have to be.
        most: measurements that there may be, or None.
        poses: distinct poses that there may be, or None.
    """

    minutes: float
    costs: Costs
    referenced: bool
    shared: bool
    validation: int = 0
    least: Structure = Structure(1, 1)
    most: int | None = None
    poses: int | None = None

    def minutes_of(self, measurements: IntArray | int, settings: IntArray | int) -> FloatArray:
        """Minutes that no plan of so many measurements at so many settings exceeds, with its rows for validation."""
        m, p = np.asarray(measurements) + self.validation, np.asarray(settings) + self.validation
        return np.asarray(most_minutes(m, p, self.costs, referenced=self.referenced, shared=self.shared), dtype=float)

    @property
    def largest(self) -> int:
        """The most measurements that fit; more than `LARGEST` are not counted; 0 where nothing fits."""
        limit, settings = LARGEST + 1 if self.most is None else self.most, max(1, self.least.poses)
        if self.poses is not None and self.poses < settings:
            return 0
        counts = np.arange(1, limit + 1)
        fit = counts[(self.minutes_of(counts, settings) <= self.minutes) & (counts >= self.least.measurements)]
        return int(fit.max(initial=0))
