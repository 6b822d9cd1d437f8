"""Descents of many designs, each towards an aim of its own, by `sqp.py`."""

from typing import NamedTuple

from expdesign.arrays import FloatArray
from expdesign.design.optimality.objectives import Objectives
from expdesign.design.optimality.sqp import MinimaxSearch
from expdesign.design.problem import DesignProblem

_RADIUS = 0.1


class Pace(NamedTuple):
    """How far descents go: number of steps at most, expected gain at which they end, and precision of every step."""

    steps: int
    tolerance: float
    inner: float


def descended(
    problem: DesignProblem, starts: FloatArray, centres: FloatArray, weights: FloatArray, pace: Pace
) -> FloatArray:
    """Designs (b, m, g) that are nearer to their aims than the starts (b, m, g).

    The aims are max_k (f_k − centre_k)·weight_k of the objectives and `total`, with centres and weights (b, k).
    """
    objectives = Objectives.with_total(problem)
    search = MinimaxSearch(problem, objectives.scalarised(centres, weights), objectives.tie(starts))
    return search.minimise(starts, iterations=pace.steps, radius=_RADIUS, tolerance=pace.tolerance, inner=pace.inner)
