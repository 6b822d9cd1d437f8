"""Boxes in the space of one measurement, and what a measurement can tell anywhere in one (theory.md 10.7).

Along a load quantity what a measurement tells is convex, so that it is largest at an end. Along the others, coordinates
of the pose above all, it is nearly a multilinear function of them in a small box: largest at a corner, or larger by
what second differences through the middle of the box say.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.planning.optimality.measurement_maps import MeasurementMaps
from expdesign.planning.optimality.sqp import Limits
from expdesign.planning.options import HALVING
from expdesign.planning.variables import Rows

Span = tuple[float, float]
"""Ends of a part of an axis."""
Box = tuple[Span, ...]


@dataclass(frozen=True)
class Axis:
    """A variable that can be chosen.

    Attributes:
        variable: its place among those of a measurement.
        order: its decisions by rising value, or the rows of a table as they stand; None for an interval, whose spans
            are parts of its range.
        values: of the quantity at these decisions; None where rows of a table have no order, or for an interval.
        convex: whether what a measurement tells is convex along it.
        angle: whether it is one (rad).
        ends: of the range, as the variable has it.
    """

    variable: int
    order: IntArray | None
    values: FloatArray | None
    convex: bool
    angle: bool
    ends: Span

    @property
    def whole(self) -> Span:
        """All of it."""
        return (0.0, 1.0) if self.order is None else (0.0, len(self.order) - 1.0)

    @property
    def listed(self) -> bool:
        """Whether its decisions have no order, so that all of them are corners."""
        return self.order is not None and self.values is None

    def corners(self, span: Span) -> list[float]:
        """Where it is looked at: at its ends, or everywhere."""
        low, high = span
        if self.listed:
            return [float(place) for place in range(int(low), int(high) + 1)]
        return [low] if low == high else [low, high]

    def halves(self, span: Span) -> tuple[Span, Span]:
        """A span of more than one decision in two."""
        low, high = span
        middle = 0.5 * (low + high)
        if self.order is None:
            return (low, middle), (middle, high)
        return (low, float(int(middle))), (int(middle) + 1.0, high)

    def middle(self, span: Span) -> tuple[float, float]:
        """A place within a span, and how far it is from the low end to the high one."""
        low, high = span
        if self.order is None or self.values is None:
            return (0.5 * (low + high) if self.order is None else float(int(0.5 * (low + high)))), 0.5
        place = int(0.5 * (low + high))
        ends = self.values[[int(low), int(high)]]
        return float(place), float((self.values[place] - ends[0]) / max(ends[1] - ends[0], 1e-300))

    def bends(self, span: Span) -> bool:
        """Whether more than its corners matters within a span."""
        low, high = span
        return not self.convex and not self.listed and high > low and (self.order is None or high - low > 1.0)

    def resolved(self, span: Span) -> bool:
        """Whether second differences through its middle tell how far from linear a function is within a span."""
        if not self.angle or not self.bends(span):
            return True
        if self.values is not None:
            return bool(abs(self.values[int(span[1])] - self.values[int(span[0])]) <= HALVING.widest)
        return (span[1] - span[0]) * (self.ends[1] - self.ends[0]) <= HALVING.widest

    def decisions(self, places: FloatArray) -> FloatArray:
        """The variable at places (b,)."""
        if self.order is None:
            return self.ends[0] + places * (self.ends[1] - self.ends[0])
        return self.order[places.astype(np.int64)].astype(float)


@dataclass(frozen=True)
class Region:
    """A box, and the places in the store where it is looked at.

    Attributes:
        corners: shape (l,).
        lines: the middle of the box and the two ends of the lines through it along every axis that bends, for every
            corner of the axes along which it is convex, shape (1 + 2a, l').
        middles: how far the middle is from the low end of each of these lines to the high one, shape (a,).
        reachable: whether any pose of it can be within the robot's limits.
        resolved: whether second differences through its middle tell enough.
    """

    corners: IntArray
    lines: IntArray
    middles: FloatArray
    reachable: bool
    resolved: bool


class Regions:
    """The boxes of a problem whose measurements share no reference.

    Args:
        information: maps of single measurements.

    Attributes:
        problem: the design problem.
        axes: what can be chosen about a measurement.
        work: number of measurements that were looked at.
    """

    def __init__(self, information: MeasurementMaps) -> None:
        problem = information.problem
        self.problem, self._space = problem, problem.space
        self._maps = information.rows
        self._limits = Limits(problem)
        loads = information.load_variables().index if information.convex_in_load else np.zeros(0, dtype=np.int64)
        self.axes = self._axes(loads, problem.loaded.robot.configuration)
        self.work = 0
        self._forget()

    @property
    def convex(self) -> bool:
        """Whether corners bound what a measurement tells without second differences."""
        return all(axis.convex or axis.listed for axis in self.axes)

    @property
    def whole(self) -> Box:
        """All that a measurement can be."""
        return tuple(axis.whole for axis in self.axes)

    def lengths(self, box: Box) -> tuple[int, ...]:
        """Number of corners along every axis."""
        return tuple(len(axis.corners(span)) for axis, span in zip(self.axes, box, strict=True))

    def decisions(self, places: FloatArray) -> FloatArray:
        """Measurements (b, g) at places (b, a) along the axes."""
        found = np.repeat(self._space.lower[None], len(places), axis=0)
        if self._space.settings is not None:
            found[:, self._space.settings.gene] = self._space.settings.first
        for column, axis in enumerate(self.axes):
            found[:, axis.variable] = axis.decisions(places[:, column])
        return found

    def corner(self, box: Box, number: int) -> FloatArray:
        """The places (a,) of a corner of a box, as `Region.corners` counts them."""
        spans = zip(self.axes, box, np.unravel_index(number, self.lengths(box)), strict=True)
        return np.array([axis.corners(span)[place] for axis, span, place in spans])

    def region(self, box: Box) -> Region:
        """What a box is looked at by."""
        found = self._regions.get(box)
        if found is None:
            found = self._regions[box] = self._looked_at(box)
        return found

    @property
    def limits(self) -> int:
        """Rows of the robot's limits."""
        return self._excess.shape[1]

    def excess(self, places: IntArray) -> FloatArray:
        """Over the robot's limits at places in the store, at most 0 within, shape (..., r)."""
        return self._excess[places]

    def grams(self, places: IntArray) -> FloatArray:
        """RᵀR, its upper triangle, at places in the store, shape (..., p)."""
        return self._grams[places]

    @cached_property
    def triangle(self) -> tuple[IntArray, IntArray]:
        """Rows and columns of the upper triangle."""
        size = self._maps(self._space.lower[None]).shape[-1]
        rows, columns = np.triu_indices(size)
        return rows, columns

    def matrices(self, triangles: FloatArray) -> FloatArray:
        """Symmetric matrices (..., q, q) of upper triangles (..., p)."""
        rows, columns = self.triangle
        size = rows[-1] + 1
        found = np.empty((*triangles.shape[:-1], size, size))
        found[..., rows, columns] = triangles
        found[..., columns, rows] = triangles
        return found

    def forms(self, roots: FloatArray) -> FloatArray:
        """What takes an upper triangle to tr(ZᵀGZ), of Z (..., q, r), shape (..., p)."""
        rows, columns = self.triangle
        products = roots @ roots.swapaxes(-1, -2)
        found: FloatArray = np.where(rows == columns, 1.0, 2.0) * products[..., rows, columns]
        return found

    def _axes(self, loads: IntArray, coordinates: tuple[str, ...]) -> tuple[Axis, ...]:
        space, axes = self._space, []
        tilt = space.n_pose + space.n_load
        chosen = space.upper > space.lower
        if space.settings is not None:
            chosen[space.settings.gene] = False
        for place in np.flatnonzero(chosen):
            domain = space.variables[place].domain
            order, values = None, None
            if isinstance(domain, Rows):
                order = np.arange(len(domain.table))
                if domain.table.shape[1] == 1:
                    order = np.argsort(domain.table[:, 0], kind="stable")
                    values = domain.table[order, 0]
            column = space.variables[place].columns[0]
            angle = column >= tilt or (column < space.n_pose and coordinates[column].endswith("_rad"))
            convex, ends = bool(np.isin(place, loads)), (float(space.lower[place]), float(space.upper[place]))
            axes.append(Axis(int(place), order, values, convex, angle, ends))
        return tuple(axes)

    def release(self) -> None:
        """Forget what was looked at, where it is much."""
        if self._used * self._grams.shape[1] * 8 > HALVING.stored:
            self._forget()

    def _forget(self) -> None:
        self._places: dict[bytes, int] = {}
        self._regions: dict[Box, Region] = {}
        self._used = 0
        rows, _ = self.triangle
        self._grams = np.empty((1024, len(rows)))
        self._excess = np.empty((1024, self._limits.rows(self._space.lower[None])[0].shape[-1] - 1))

    def _looked_at(self, box: Box) -> Region:
        spans = list(zip(self.axes, box, strict=True))
        ends = [axis.corners(span) for axis, span in spans]
        middle = [axis.middle(span) for axis, span in spans]
        bending = [place for place, (axis, span) in enumerate(spans) if axis.bends(span)]
        held = [end if axis.convex else [at[0]] for end, (axis, _), at in zip(ends, spans, middle, strict=True)]
        centres = _every(held)
        lines = [centres]
        for place in bending:
            for end in box[place]:
                lines.append(centres.copy())
                lines[-1][:, place] = end
        places = _every(ends)
        stored = self._stored(np.concatenate([places, *lines]))
        corners, at_lines = stored[: len(places)], stored[len(places) :].reshape(len(lines), -1)
        middles = np.array([middle[place][1] for place in bending])
        least = self._excess[corners].min(axis=0)
        least = least - HALVING.safety * above_lines(-self._excess[at_lines], middles[:, None, None]).max(axis=0)
        resolved = all(axis.resolved(span) for axis, span in spans)
        return Region(corners, at_lines, middles, not bool((least > 0.0).any()), resolved)

    def _stored(self, places: FloatArray) -> IntArray:
        """Where measurements (b, a) are in the store, which those that are new enter, shape (b,)."""
        keys = [row.tobytes() for row in np.ascontiguousarray(places)]
        new: dict[bytes, int] = {}
        for number, key in enumerate(keys):
            if key not in self._places and key not in new:
                new[key] = number
        if new:
            decisions = self.decisions(places[list(new.values())])
            rows = self._maps(decisions)
            first, second = self.triangle
            grams = (rows[..., first] * rows[..., second]).sum(axis=1)
            excess = self._limits.rows(decisions, condition_row=False)[0][:, :-1]
            end = self._used + len(new)
            while end > len(self._grams):
                self._grams = np.concatenate([self._grams, np.empty_like(self._grams)])
                self._excess = np.concatenate([self._excess, np.empty_like(self._excess)])
            self._grams[self._used : end], self._excess[self._used : end] = grams, excess
            self._places |= {key: self._used + number for number, key in enumerate(new)}
            self._used = end
            self.work += len(new)
        return np.array([self._places[key] for key in keys])


def above_lines(values: FloatArray, middles: FloatArray) -> FloatArray:
    """How far the middle of a box is above the straight lines between the ends, shape (...).

    Args:
        values: at the middle and the two ends of each line, shape (1 + 2a, ...).
        middles: see `Region`, shape (a, ...).
    """
    above: FloatArray = np.maximum(values[0] - (1.0 - middles) * values[1::2] - middles * values[2::2], 0.0)
    return above.sum(axis=0)


def _every(places: list[list[float]]) -> FloatArray:
    """All combinations of places along the axes, shape (b, a)."""
    found = list(product(*places))
    return np.array(found, dtype=float).reshape(len(found), len(places))
