"""Descents of many designs, each towards an aim of its own, by `sqp.py`."""

from typing import NamedTuple

from expdesign.arrays import FloatArray
from expdesign.design.optimality.objectives import Objectives
from expdesign.design.optimality.pose_groups import PoseGroups
from expdesign.design.optimality.sqp import MinimaxSearch
from expdesign.design.problem import DesignProblem


class Pace(NamedTuple):
    """How far descents go: number of steps at most, expected gain at which they end, precision of every step, and
    how far the first step may go, in parts of the ranges.
    """

    steps: int
    tolerance: float
    inner: float
    radius: float = 0.1


def descended(
    problem: DesignProblem, starts: FloatArray, centres: FloatArray, weights: FloatArray, pace: Pace
) -> FloatArray:
    """Designs (b, m, g) that are nearer to their aims than the starts (b, m, g).

    The aims are max_k (f_k − centre_k)·weight_k of the objectives and `total`, with centres and weights (b, k).
    """
    return pursued(Objectives.with_total(problem), starts, centres, weights, pace)


def pursued(
    objectives: Objectives, starts: FloatArray, centres: FloatArray, weights: FloatArray, pace: Pace
) -> FloatArray:
    """The same for any objectives f_k. Measurements that share their reference keep sharing it, and no others do."""
    groups = PoseGroups.of(objectives.problem, starts)
    series, tie = (None, None) if groups is None else (groups.series, groups.tied)
    search = MinimaxSearch(objectives.problem, objectives.scalarised(centres, weights, series), tie)
    found = search.minimise(
        starts, iterations=pace.steps, radius=pace.radius, tolerance=pace.tolerance, inner=pace.inner
    )
    return found if groups is None else groups.apart(found)
