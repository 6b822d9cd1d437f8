"""Descents of designs along exact gradients of objectives (`sqp.py`)."""

from typing import NamedTuple

from expdesign.arrays import FloatArray
from expdesign.planning.optimality.objectives import Objectives
from expdesign.planning.optimality.pose_groups import PoseGroups
from expdesign.planning.optimality.sqp import MinimaxSearch
from expdesign.planning.scalarisation import Aims


class Pace(NamedTuple):
    """How far descents go.

    Attributes:
        steps: largest number of them.
        tolerance: expected relative gain at which they end.
        inner: precision of the programs of every step.
        radius: how far the first step may go, in parts of the ranges.
    """

    steps: int
    tolerance: float = 1e-6
    inner: float = 1e-3
    radius: float = 0.1


def descended(objectives: Objectives, starts: FloatArray, aims: Aims, pace: Pace) -> tuple[FloatArray, int]:
    """Designs (b, m, g) nearer to their aims than the starts (b, m, g), and how many steps of single designs it took.

    Measurements that share their reference keep sharing it, and no others do.
    """
    groups = PoseGroups.of(objectives.problem, starts)
    series, tie = (None, None) if groups is None else (groups.numbers, groups.tied)
    search = MinimaxSearch(objectives.problem, objectives.scalarised(aims, series), tie)
    found = search.minimise(
        starts, iterations=pace.steps, radius=pace.radius, tolerance=pace.tolerance, inner=pace.inner
    )
    return (found if groups is None else groups.apart(found)), search.steps
