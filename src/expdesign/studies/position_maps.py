"""Criteria over the position at which a bipod is identified by one measurement."""

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.criteria.assessment import Assessment
from expdesign.design.plan import Plan
from expdesign.design.problem import DesignProblem
from expdesign.errors import InputError

MICRO = 1e6
"""µm in a metre."""


def grid_assessment(problem: DesignProblem) -> tuple[FloatArray, Assessment]:
    """All poses of a problem's grid (N, 2), and the assessment of the N plans of one measurement under its fixed load.

    Raises:
        InputError: poses are not a grid, or the load is not fixed.
    """
    space = problem.space
    if space.genes != 2 or not space.discrete.all():
        what = "the study needs poses on a `grid` of x and y, and a fixed load"
        raise InputError(what, where=problem.source, remedy="See the configuration that is shipped.")
    indices = (np.arange(int(upper) + 1.0) for upper in space.upper)
    genes = np.stack(np.meshgrid(*indices, indexing="ij"), axis=-1).reshape(-1, 1, 2)
    poses, loads = space.decode(genes)
    return poses[:, 0], problem.assess(poses, loads)


def fixed_load(problem: DesignProblem) -> FloatArray:
    """The one load of the experiment (k,)."""
    genes = np.full((1, problem.space.genes), 0.5)
    return problem.space.decode(genes)[1][0]


def plan_at(problem: DesignProblem, pose: FloatArray) -> Plan:
    """One measurement at a pose (n,)."""
    return Plan(pose[None], fixed_load(problem)[None], np.array([1]))


def map_frame(poses: FloatArray, columns: dict[str, FloatArray], step: int) -> pd.DataFrame:
    """Columns over x and y, every `step`-th point along each."""
    kept = np.ones(len(poses), dtype=bool)
    for axis in range(2):
        values = np.unique(poses[:, axis])
        kept &= np.isin(poses[:, axis], values[::step])
    frame = pd.DataFrame({"x_m": poses[kept, 0].round(9), "y_m": poses[kept, 1].round(9)})
    for name, values in columns.items():
        frame[name] = values[kept]
    return frame
