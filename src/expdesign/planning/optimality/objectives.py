"""The objectives of a front, all to be minimised, as smooth pieces, and descents of designs along their exact gradients
(`sqp.py`). Measurements of one setting of the robot stay at one pose together while gradients move it.
"""

from functools import cached_property
from typing import NamedTuple

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import criterion_values, known_criteria
from expdesign.planning.optimality.differentiated import Differentiated, Piece, shared_series, weighted_gradient
from expdesign.planning.optimality.sqp import MinimaxSearch, Tie
from expdesign.planning.problem import DesignProblem
from expdesign.planning.scalarisation import Aims
from expdesign.planning.space import DesignSpace


class Objectives:
    """The criteria of a front with those to be maximised negated, and behind them `total`, where it is none of them.

    Attributes:
        problem: the design problem.
        criteria: the objectives and, behind them, `total`.
        count: number of the objectives.
    """

    def __init__(self, problem: DesignProblem) -> None:
        self.problem = problem
        total = known_criteria()["total"]
        self.criteria = problem.objectives if total in problem.objectives else (*problem.objectives, total)
        self.count = len(problem.objectives)
        self._signs = [-1.0 if criterion.maximise else 1.0 for criterion in self.criteria]

    def pieces(self, index: int, designs: Differentiated) -> list[Piece]:
        """Smooth functions of which objective `index` is the largest, that one first."""
        found = designs.pieces(self.criteria[index])
        return found if self._signs[index] > 0.0 else [piece.negated() for piece in found]

    @property
    def names(self) -> tuple[str, ...]:
        """Of the criteria."""
        return tuple(criterion.name for criterion in self.criteria)

    @cached_property
    def smooth(self) -> bool:
        """Whether designs can descend: something is continuous, and exact gradients of any criterion are known."""
        space = self.problem.space
        free = bool((~space.discrete & (space.upper > space.lower)).any())
        return free and bool(self.differentiable.any()) and not self.problem.loaded.regressor.redundant

    @property
    def differentiable(self) -> BoolArray:
        """Which criteria have gradients, shape (k,)."""
        return np.array([criterion.differentiable for criterion in self.criteria])

    def values(self, assessment: Assessment) -> FloatArray:
        """Criteria (b, k), minimised, of designs that were assessed; NaN where targets are not identified."""
        both = zip(self._signs, self.criteria, strict=True)
        return np.stack([sign * criterion_values(criterion, assessment) for sign, criterion in both], axis=1)

    def plain(self, values: FloatArray) -> dict[str, FloatArray]:
        """Criteria (b,) as they are, by names, of minimised ones (b, k)."""
        return {name: sign * column for name, sign, column in zip(self.names, self._signs, values.T, strict=True)}


class Scalarised:
    """Pieces φ = (f_k − centre_k)·weight_k of the achievement function of each design (see `sqp.Pieces`); a weight of 0
    leaves f_k out. Series (b, m) of measurements that share their reference are held where they are given.
    """

    def __init__(self, objectives: Objectives, aims: Aims, series: IntArray | None) -> None:
        self._objectives, self._centres, self._weights, self._series = objectives, aims.centres, aims.weights, series
        self._used = np.flatnonzero((aims.weights > 0.0).any(axis=0))

    def __call__(self, variables: FloatArray, index: IntArray) -> tuple[FloatArray, FloatArray]:
        """Values (b, j) and gradients (b, j, m, g), j the largest number of pieces that count for any one design: a
        backward pass costs the same whether it is of one criterion everywhere or of another for every design.
        """
        series = None if self._series is None else self._series[index]
        designs = Differentiated.of_designs(self._objectives.problem, variables, series)
        found = [(k, piece) for k in self._used for piece in self._objectives.pieces(int(k), designs)]
        columns = np.array([k for k, _ in found], dtype=np.int64)
        number = int((self._weights[:, columns] > 0.0).sum(axis=1).max(initial=0))
        weights = self._weights[index][:, columns]
        place = np.cumsum(weights > 0.0, axis=1) - 1
        values = np.full((len(index), number), _ABSENT)
        slopes = np.empty(
            (len(index), number, *designs.quantities.shape[1:2], self._objectives.problem.space.decisions)
        )
        for j in range(number):
            chosen = np.where((place == j) & (weights > 0.0), weights, 0.0)
            with np.errstate(invalid="ignore"):
                for column, (k, piece) in enumerate(found):
                    value = (piece.value - self._centres[index, k]) * chosen[:, column]
                    values[:, j] = np.where(chosen[:, column] > 0.0, value, values[:, j])
            slopes[:, j] = weighted_gradient([piece for _, piece in found], chosen.T)
        return np.where(designs.regular[:, None], values, np.nan), slopes


_ABSENT = -1e4
"""Value of a piece that is left out: far below the others, so that it is never the largest."""


def tied(space: DesignSpace, series: IntArray | None) -> Tie | None:
    """What makes changes of variables (c, m, g) of the designs with some indices (c,) the same for all poses of one of
    their series (b, m), by their mean; None where there are none.
    """
    if series is None:
        return None
    same = (series[:, :, None] == series[:, None]).astype(float)
    mean = same / same.sum(axis=2, keepdims=True)
    return lambda steps, index: np.where(space.of_pose, mean[index] @ steps, steps)


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


def descended(objectives: Objectives, starts: FloatArray, aims: Aims, pace: Pace) -> FloatArray:
    """Designs (b, m, g) nearer to their aims than the starts (b, m, g).

    Measurements that share their reference keep sharing it, and no others do. Where an aim asks for a criterion without
    gradient, the start stays.
    """
    without: BoolArray = np.logical_or.reduce(
        aims.weights[:, ~objectives.differentiable[: aims.weights.shape[1]]] > 0.0, axis=1
    )
    if without.any():
        found = starts.copy()
        found[~without] = descended(objectives, starts[~without], aims[~without], pace)
        return found
    space = objectives.problem.space
    series = shared_series(objectives.problem, space.quantities(starts))
    search = MinimaxSearch(objectives.problem, Scalarised(objectives, aims, series), tied(space, series))
    found = search.minimise(
        starts, iterations=pace.steps, radius=pace.radius, tolerance=pace.tolerance, inner=pace.inner
    )
    if series is not None and space.settings is not None and space.settings.shared:
        # Series keep references of their own also where they meet at one pose.
        gene = space.settings.gene
        found[..., gene] = np.where(series > 0, space.settings.first + series - 1.0, found[..., gene])
    return found
