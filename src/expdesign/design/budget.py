"""A budget of time in place of a number of measurements (`experiment.budget`).

How long a plan takes depends on its structure alone: m measurements at no more than p distinct poses. Every structure
that fits the budget and to which nothing can be added is a candidate; among them the search chooses.
"""

from dataclasses import dataclass

from expdesign.design.laboratory_sheet import Costs
from expdesign.design.measuring_time import most_minutes

LARGEST = 200
"""Measurements beyond which a budget alone does not decide."""


@dataclass(frozen=True)
class Structure:
    """So many measurements at no more than so many distinct poses."""

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

    def most_minutes(self, structure: Structure) -> float:
        """Minutes that no plan of a structure exceeds, with its rows for validation (min)."""
        m, p = structure.measurements + self.validation, structure.poses + self.validation
        return most_minutes(m, p, self.costs, referenced=self.referenced, shared=self.shared)

    def structures(self) -> list[Structure]:
        """For every number of poses the most measurements that fit, fewest poses first; empty where nothing fits.

        A structure with no more measurements than one of more poses is left out: what it allows, the other allows too.
        Of measurements beyond `LARGEST` there is no end; they are not looked for.
        """
        found: list[Structure] = []
        limit = LARGEST + 1 if self.most is None else self.most
        for poses in range(self.least.poses, min(limit, self.poses or limit) + 1):
            count = max(poses, self.least.measurements)
            if count > limit or self.most_minutes(Structure(count, poses)) > self.minutes:
                break
            while count < limit and self.most_minutes(Structure(count + 1, poses)) <= self.minutes:
                count += 1
            found = [known for known in found if known.measurements > count]
            found.append(Structure(count, poses))
        return found
