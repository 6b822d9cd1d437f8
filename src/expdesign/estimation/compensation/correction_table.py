"""Corrections of commands on a grid over poses and loads, fine enough for a stated error of interpolation.

The correction is command − target of `compensate`. Between the nodes it is interpolated multilinearly: linearly along
each of the d axes in turn. For a function f with continuous second derivatives the error of that on a box with steps h
is at most

    |f − If| ≤ Σ_k h_k²/8 · max|∂²f/∂x_k²|

(the one-dimensional bound h²/8·max|f″|, de Boor, A Practical Guide to Splines, ch. III, applied along each axis; the
operators along the axes have norm 1, so that the errors add up). The largest second derivatives are sampled by central
differences at the corners and at random points, and taken `SAFETY` times as large. With them the least number of nodes
is chosen for which the bound is below the wanted error. Then the table is compared with the exact correction at the
centres of cells and at random points; where an error there, times `MARGIN`, is above the wanted one (a model that is
not smooth), the grid is refined further. The stated error is the larger one of the bound and of `MARGIN` times what
was found. A correction is linear in loads to first order, so that two nodes are enough for most of them.
"""

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.errors import ConvergenceError

SAFETY = 1.5
MARGIN = 1.25
ROUNDING = 1e-12
"""m, rad: corrections themselves are known no better; no smaller error is stated."""
_SAMPLES = 200
_CHECKS = 4000
_STEP = 0.125
"""Step of the differences in parts of an axis; corrections are known to 1e-13, their differences must be larger."""
_ROUNDS = 12

Function = Callable[[FloatArray], FloatArray]
"""Exact corrections (N, o) at points (N, d)."""


@dataclass(frozen=True)
class CorrectionGrid:
    """A box with equidistant nodes.

    Attributes:
        low: of each axis, shape (d,).
        high: likewise.
        counts: nodes along each axis, at least 2, shape (d,).
    """

    low: FloatArray
    high: FloatArray
    counts: IntArray

    @property
    def nodes(self) -> FloatArray:
        """All nodes, the last axis running fastest, shape (n, d)."""
        nodes: FloatArray = np.stack(np.meshgrid(*self._axes, indexing="ij"), axis=-1).reshape(-1, len(self.counts))
        return nodes

    @property
    def _axes(self) -> list[FloatArray]:
        return [np.linspace(a, b, n) for a, b, n in zip(self.low, self.high, self.counts, strict=True)]

    def interpolate(self, values: FloatArray, points: FloatArray) -> FloatArray:
        """Multilinear interpolation of values (n, o) at the nodes, at points (N, d) in the box, shape (N, o)."""
        from scipy.interpolate import RegularGridInterpolator  # noqa: PLC0415 (slow to import, and few need it)

        table = RegularGridInterpolator(
            self._axes, values.reshape(*self.counts, -1), bounds_error=False, fill_value=None
        )
        found: FloatArray = table(points)
        return found

    def random(self, number: int, generator: np.random.Generator) -> FloatArray:
        """Random points in the box, shape (number, d)."""
        points: FloatArray = self.low + (self.high - self.low) * generator.random((number, len(self.low)))
        return points

    def centres(self, number: int, generator: np.random.Generator) -> FloatArray:
        """Centres of all cells, or of `number` random ones where there are more, shape (m, d)."""
        cells = self.counts - 1
        if cells.prod() <= number:
            index = np.stack(np.unravel_index(np.arange(cells.prod()), cells), axis=1)
        else:
            index = generator.integers(0, cells, (number, len(cells)))
        centres: FloatArray = self.low + (index + 0.5) * (self.high - self.low) / cells
        return centres


@dataclass(frozen=True)
class CorrectionTable:
    """A table whose interpolation is as exact as it says.

    Attributes:
        grid: where the nodes are.
        values: corrections at the nodes (m, rad), shape (n, o).
        stated: largest error of interpolation that is to be expected (m, rad), shape (o,).
        bound: Σ_k h_k²/8·max|f″| with the sampled second derivatives times `SAFETY`, shape (o,).
        found: largest error at centres and random points, shape (o,).
        checks: number of these points.
    """

    grid: CorrectionGrid
    values: FloatArray
    stated: FloatArray
    bound: FloatArray
    found: FloatArray
    checks: int


def correction_table(
    exact: Function, low: FloatArray, high: FloatArray, wanted: FloatArray, *, most: int, seed: int = 1
) -> CorrectionTable:
    """The coarsest grid whose stated error is below the wanted one.

    Args:
        exact: the corrections.
        low: of each axis, shape (d,).
        high: likewise; larger than `low`.
        wanted: largest error of each correction (m, rad), shape (o,).
        most: nodes at most.
        seed: of the random points.

    Raises:
        ConvergenceError: more than `most` nodes would be needed.
    """
    generator = np.random.default_rng(seed)
    curvature = _curvature(exact, low, high, generator)
    tightened = np.ones(len(wanted))
    for _ in range(_ROUNDS):
        counts = _least_counts(curvature, wanted / tightened, most)
        grid = CorrectionGrid(low, high, counts)
        values = exact(grid.nodes)
        points = np.concatenate([grid.centres(_CHECKS, generator), grid.random(_CHECKS, generator)])
        found = np.abs(grid.interpolate(values, points) - exact(points)).max(axis=0)
        bound = (curvature / (counts[:, None] - 1.0) ** 2).sum(axis=0)
        stated = np.maximum(np.maximum(bound, MARGIN * found), ROUNDING)
        if np.all(stated <= wanted):
            return CorrectionTable(grid, values, stated, bound, found, len(points))
        tightened *= np.maximum(1.2, MARGIN * found / wanted)
    raise _too_fine(most)


def _curvature(exact: Function, low: FloatArray, high: FloatArray, generator: np.random.Generator) -> FloatArray:
    """SAFETY · L_k²/8 · max|∂²f_o/∂x_k²|: the bound of one cell over the whole axis, shape (d, o)."""
    count = len(low)
    corners = np.array(list(itertools.product((0.0, 1.0), repeat=count)))
    corners = corners[generator.permutation(len(corners))[:_SAMPLES]]
    parts = np.concatenate([corners, np.full((1, count), 0.5), generator.random((_SAMPLES, count))])
    curvature = []
    for axis in range(count):
        stencil = np.repeat(parts[None], 3, axis=0)
        stencil[:, :, axis] = np.clip(parts[:, axis], _STEP, 1.0 - _STEP) + _STEP * np.array([[-1.0], [0.0], [1.0]])
        values = exact((low + (high - low) * stencil).reshape(-1, count)).reshape(3, len(parts), -1)
        second = (values[0] - 2.0 * values[1] + values[2]) / _STEP**2
        curvature.append(SAFETY * np.abs(second).max(axis=0) / 8.0)
    return np.array(curvature)


def _least_counts(curvature: FloatArray, wanted: FloatArray, most: int) -> IntArray:
    """Numbers of nodes along the axes for Σ_k C_k/(n_k − 1)² ≤ wanted, their product nearly least.

    Nodes are added one by one where they lower the bound most for the share of nodes that they cost.
    """
    counts = np.full(len(curvature), 2, dtype=np.int64)
    while True:
        parts = curvature / wanted / (counts[:, None] - 1.0) ** 2
        over = parts.sum(axis=0) > 1.0
        if not over.any():
            return counts
        gain = (parts * (1.0 - ((counts[:, None] - 1.0) / counts[:, None]) ** 2))[:, over].sum(axis=1)
        counts[int(np.argmax(gain / np.log1p(1.0 / counts)))] += 1
        if float(np.prod(counts.astype(float))) > most:
            raise _too_fine(most)


def _too_fine(most: int) -> ConvergenceError:
    what = f"a table of that error would need more than {most} nodes"
    remedy = "Allow a larger error or more nodes, take smaller ranges, or hold some coordinates."
    return ConvergenceError(what, remedy=remedy)
