"""The front of a space that is small enough to look at every design in it."""

from itertools import combinations_with_replacement
from math import comb

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.front import non_dominated
from expdesign.planning.optimality.objectives import Objectives
from expdesign.planning.problem import DesignProblem

ENUMERABLE = 40_000
"""Largest number of designs that are all looked at."""
_TOGETHER = 5_000


def every_design(problem: DesignProblem) -> FloatArray | None:
    """The designs (d, m, g) that no other one dominates, in a space of finitely many; None where they are too many."""
    space = problem.space
    if (
        not space.discrete.all()
        or (space.settings is not None and space.settings.budget is not None)
        or space.required.poses
        or space.required.masses
    ):
        return None
    levels = [int(high) + 1 for high in space.upper]
    count, m = int(np.prod(levels, dtype=np.float64)), space.measurements
    if comb(count + m - 1, m) > ENUMERABLE:
        return None
    axes = np.meshgrid(*(np.arange(number, dtype=float) for number in levels), indexing="ij")
    measurements = np.stack([axis.ravel() for axis in axes], axis=1)
    measurements = measurements[problem.loaded.robot.usable(space.decode(measurements)[0])]
    plans = np.array(list(combinations_with_replacement(range(len(measurements)), m)), dtype=np.int64)
    objectives = Objectives(problem)
    best = np.zeros((0, m, space.decisions))
    for start in range(0, len(plans), _TOGETHER):
        listed = np.unique(space.canonical(measurements[plans[start : start + _TOGETHER]]), axis=0)
        designs = np.concatenate([best, listed])
        values = objectives.values(designs)
        finite = np.isfinite(values).all(axis=1)
        if problem.constraints is not None:
            broken = problem.constraints.violations(problem.loaded, *space.decode(designs)) > 0.0
            finite &= ~broken.any(axis=1)
        designs, values = designs[finite], values[finite]
        best = designs[non_dominated(values)] if len(designs) else best
    return best
