"""Criteria over the position at which a bipod is identified by one measurement."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from expdesign.arrays import FloatArray
from expdesign.errors import InputError
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem

COORDINATES = "Positions are pose coordinates, from the centre of the workspace."
BEST_COLOUR = "#dc2626"
MICRO = 1e6
"""µm in a metre."""


def grid_assessment(problem: DesignProblem, points: int = 0) -> tuple[FloatArray, Assessment]:
    """All poses of a grid (N, 2), x slowest, and the assessment of the N plans of one measurement under its fixed load.

    Args:
        problem: with poses on a grid, or between bounds.
        points: per axis, for poses between bounds.

    Raises:
        InputError: not x and y alone are to be chosen.
    """
    space = problem.space
    if space.decisions != 2 or (not space.discrete.all() and points < 2):
        what = "the study needs poses on a `grid` of x and y, and a fixed load"
        raise InputError(what, where=problem.source, remedy="See the configuration that is shipped.")
    counts = np.where(space.discrete, space.upper + 1.0, points).astype(int)
    axes = (np.linspace(low, high, count) for low, high, count in zip(space.lower, space.upper, counts))
    decisions = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 1, 2)
    poses, loads = space.decode(decisions)
    return poses[:, 0], problem.assess(poses, loads)


def fixed_load(problem: DesignProblem) -> FloatArray:
    """The one load of the experiment (k,)."""
    decisions = np.full((1, problem.space.decisions), 0.5)
    return problem.space.decode(decisions)[1][0]


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


def best_index(name: str, values: FloatArray) -> int:
    """Row of the best value; a criterion that is to be large is known by its name."""
    criterion = known_criteria().get(name)
    larger = criterion is not None and criterion.maximise
    return int(np.nanargmax(values) if larger else np.nanargmin(values))


def mark_best(axis: Axes, x: float, y: float) -> None:
    """A star at the best position of a map."""
    axis.plot(x, y, marker="*", color=BEST_COLOUR, markersize=11, clip_on=False)
