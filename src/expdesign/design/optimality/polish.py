"""Gradient refinement of a front (theory.md 6): from good designs to designs that satisfy the optimality conditions.

The designs given are joined by roundings of the convex relaxation (`seeds.py`). Points are laid out evenly along the
front, its ends among them. Each point is pursued along a fixed direction in the space of the objectives,
min max_k (f_k − z_k)/span_k (Pascoletti & Serafini 1984), which reaches convex and concave parts alike, from the best
design known for it; then again from what its neighbours found. A few points are enough until the front is where it
belongs; only the last round pursues them all.
"""

from collections.abc import Callable, Iterator

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.criteria.criterion import Criterion, known_criteria
from expdesign.design.front import non_dominated
from expdesign.design.optimality.kktpm import kktpm
from expdesign.design.optimality.objectives import Objectives
from expdesign.design.optimality.seeds import relaxed_designs
from expdesign.design.optimality.sqp import MinimaxSearch
from expdesign.design.problem import DesignProblem
from expdesign.design.start import reachable_measurements

Report = Callable[[str], None]
Round = tuple[bool, int, float]
"""Whether measurements are exchanged between designs first, the largest number of steps, and the part of the points
along the front that is pursued."""
_COARSE: tuple[Round, ...] = ((False, 5, 0.3), (True, 12, 0.3), (False, 12, 0.3))
_DESCENT: tuple[Round, ...] = ((False, 20, 0.3),)
_FINE: tuple[Round, ...] = ((True, 12, 0.5), (True, 20, 0.5), (False, 60, 1.0))
TARGET = 1e-4
"""KKT proximity at which a design counts as finished."""
_CHILDREN, _RESTARTS, _CAPACITY = 24, 6, 400_000_000


def polish(
    problem: DesignProblem, variables: FloatArray, report: Report = lambda text: None, *, points: int | None = None
) -> FloatArray:
    """Designs that improve a front, to be merged with it.

    Args:
        problem: the design problem.
        variables: feasible designs, e.g. a front, shape (d, m, g).
        report: told in words about each round.
        points: how many designs along the front are wanted; as many as the search's population where left out.

    Returns:
        Designs (d', m, g), within bounds and limits, among them the best for each objective alone and for `total`.
        Discrete variables are those of the designs that they came from. The same arguments give the same designs.
    """
    last = variables
    for number, last in enumerate(polish_rounds(problem, variables, points=points), start=1):
        report(f"polish, round {number}: {len(last)} designs")
    return last


def polish_rounds(problem: DesignProblem, variables: FloatArray, *, points: int | None = None) -> Iterator[FloatArray]:
    """What `polish` has reached after each of its rounds; the arguments are the same."""
    last = variables
    for last in coarse_rounds(problem, variables, points=points):
        yield last
    yield from fine_rounds(problem, last, points=points)


def coarse_rounds(problem: DesignProblem, variables: FloatArray, *, points: int | None = None) -> Iterator[FloatArray]:
    """The rounds that find where the front lies, with the designs of the relaxation; see `polish`."""
    designs = np.concatenate([variables, relaxed_designs(problem)])
    yield designs
    if (~problem.space.discrete).any():
        yield from _Polish(problem, points or problem.optimiser.population, 0).run(designs, _COARSE)


def fine_rounds(
    problem: DesignProblem, variables: FloatArray, others: FloatArray | None = None, *, points: int | None = None
) -> Iterator[FloatArray]:
    """The rounds that make every point of the front satisfy the optimality conditions; see `polish`.

    `others` are designs (d, m, g) from another search. They descend by themselves before the two compete, because
    designs of a better valley may still be worse than refined ones of another.
    """
    if (~problem.space.discrete).any():
        polishing = _Polish(problem, points or problem.optimiser.population, 1)
        pool = variables
        if others is not None:
            descended = list(polishing.run(others, _DESCENT))[-1]
            pool = np.concatenate([variables, descended])
            yield pool
        last = pool
        for last in polishing.run(pool, _FINE):
            yield last
        yield polishing.finished(last)


class _Polish:
    """The rounds of one refinement; `stream` separates its random numbers from those of other rounds."""

    def __init__(self, problem: DesignProblem, points: int, stream: int) -> None:
        known = known_criteria()
        further: tuple[Criterion, ...] = () if known["total"] in problem.objectives else (known["total"],)
        self._problem = problem
        # The cost of a step grows with the cube of the number of variables: with very many, few points are pursued, and
        # not to the end.
        unknowns = problem.space.measurements * int((~problem.space.discrete).sum())
        affordable = max(1, _CAPACITY // unknowns**3)
        self._restarts = min(_RESTARTS, max(1, affordable // 20))
        self._points = min(points, affordable)
        self._part = min(1.0, 0.25 * _CAPACITY / unknowns**3)
        self._objectives = Objectives(problem, further)
        self._count = self._objectives.count
        self._robot = problem.loaded.robot
        self._generator = np.random.default_rng([problem.optimiser.seed, stream])

    def run(self, variables: FloatArray, rounds: tuple[Round, ...]) -> Iterator[FloatArray]:
        """The designs kept after each round."""
        pool, values = self._usable(variables)
        if len(pool) == 0:
            yield variables
            return
        for mixed, iterations, part in rounds:
            centres, weights = self._aims(values, max(1, round(part * self._points)))
            starts = pool[self._starts(values, centres, weights)]
            if mixed:
                starts = self._mixed(starts, pool, centres, weights)
            found = self._minimise(starts, centres, weights, iterations)
            pool, values = self._usable(np.concatenate([pool, found]))
            kept = self._kept(values)
            pool, values = pool[kept], values[kept]
            yield pool

    def finished(self, pool: FloatArray) -> FloatArray:
        """The pool with what is still rough finished or, where the front can do without it, left out."""
        pool, values = self._usable(pool)
        if len(pool) == 0:
            return pool
        measure = kktpm(self._problem, pool)
        rough = np.flatnonzero(~(measure <= TARGET))
        space = self._problem.space
        # In steps as coarse as that, the optimum that can be set does not satisfy the conditions of the continuous one.
        coarse = bool((space.grid.steps > TARGET * (space.upper - space.lower)).any())
        # Nor does one that other constraints hold.
        if rough.size == 0 or coarse or self._problem.constraints is not None:
            return pool
        weights = np.zeros_like(values[rough])
        weights[:, : self._count] = 1.0 / Objectives.spans(values)[: self._count]
        found = self._minimise(pool[rough], values[rough], weights, _FINE[-1][1])
        pool, values = self._usable(np.concatenate([np.delete(pool, rough, axis=0), found, pool[rough]]))
        kept = self._kept(values)
        pool, values = pool[kept], values[kept]
        smooth = kktpm(self._problem, pool) <= TARGET
        smooth[np.argmin(values, axis=0)] = True
        return pool[smooth]

    def _usable(self, variables: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Designs that are within the limits and identify everything, and their criteria."""
        variables = self._problem.settable(variables)
        values = self._objectives.values(variables)
        poses, loads = self._problem.space.decode(variables)
        usable = self._robot.usable(poses).all(axis=1) & np.isfinite(values).all(axis=1)
        constraints = self._problem.constraints
        if constraints is not None:
            usable &= (constraints.violations(self._problem.loaded, poses, loads) <= 0.0).all(axis=1)
        return variables[usable], values[usable]

    def _kept(self, values: FloatArray) -> IntArray:
        """The non-dominated designs, with the best of each criterion even where that one is not an objective."""
        best = np.argmin(values, axis=0)
        return np.unique(np.concatenate([non_dominated(values[:, : self._count]), best]))

    def _aims(self, values: FloatArray, points: int) -> tuple[FloatArray, FloatArray]:
        """Centres z and weights (b, k) of the achievement functions: the ends and `total`, then along the front.

        What everything else hangs on, the ends and `total`, is aimed at from several starts.
        """
        total = values.shape[1]
        front = values[non_dominated(values[:, : self._count])]
        span = Objectives.spans(values)
        single = np.repeat(np.eye(total) / span, self._restarts, axis=0)
        centres = np.tile(values.min(axis=0), (len(single), 1))
        along = _spread(front[:, : self._count] / span[: self._count], points) * span[: self._count]
        inner = np.zeros((len(along), total))
        inner[:, : self._count] = along
        weights = np.zeros_like(inner)
        weights[:, : self._count] = 1.0 / span[: self._count]
        return np.concatenate([centres, inner]), np.concatenate([single, weights])

    def _starts(self, values: FloatArray, centres: FloatArray, weights: FloatArray) -> IntArray:
        """For each aim the design of the pool that serves it best; for its repetitions the next best ones."""
        order = np.argsort(_achieved(values[None], centres[:, None], weights[:, None]), axis=1, kind="stable")
        place = np.zeros(len(order), dtype=np.int64)
        singles = self._restarts * values.shape[1]
        place[:singles] = np.minimum(np.tile(np.arange(self._restarts), values.shape[1]), len(values) - 1)
        best: IntArray = order[np.arange(len(order)), place]
        return best

    def _mixed(self, parents: FloatArray, pool: FloatArray, centres: FloatArray, weights: FloatArray) -> FloatArray:
        """For each aim the best of some children of its design, each with a measurement of another design in it.

        Gradients stay in the valley where they start; this is how one leaves it.
        """
        count, m, _ = parents.shape
        donors = pool[self._generator.integers(len(pool), size=(count, _CHILDREN))]
        taken = self._generator.integers(m, size=(count, _CHILDREN, 2))
        children = np.repeat(parents[:, None], _CHILDREN, axis=1)
        first, second = np.indices((count, _CHILDREN))
        new = donors[first, second, taken[..., 1]]
        random = reachable_measurements(self._problem, count * _CHILDREN // 4, self._generator)
        new[:, : _CHILDREN // 4] = random.reshape(count, _CHILDREN // 4, -1)
        children[first, second, taken[..., 0]] = new
        children = self._problem.space.canonical(children)
        values = self._objectives.values(children.reshape(-1, *parents.shape[1:])).reshape(count, _CHILDREN, -1)
        same = (children == parents[:, None]).all(axis=(2, 3))
        achieved = _achieved(values, centres[:, None], weights[:, None])
        best = np.argmin(np.where(same, np.inf, np.nan_to_num(achieved, nan=np.inf)), axis=1)
        chosen: FloatArray = children[np.arange(count), best]
        return chosen

    def _minimise(self, starts: FloatArray, centres: FloatArray, weights: FloatArray, iterations: int) -> FloatArray:
        pieces = self._objectives.scalarised(centres, weights)
        search = MinimaxSearch(self._problem, pieces, self._objectives.tie(starts))
        return search.minimise(starts, iterations=max(2, round(self._part * iterations)), radius=0.1)


def _achieved(values: FloatArray, centres: FloatArray, weights: FloatArray) -> FloatArray:
    """max_k (f_k − centre_k)·weight_k over the criteria that have weight, of (..., k)."""
    achieved: FloatArray = np.where(weights > 0.0, (values - centres) * weights, -np.inf).max(axis=-1)
    return achieved


def _spread(front: FloatArray, count: int) -> FloatArray:
    """Points (count, k) evenly spaced along a front (d, k) of two objectives; of more objectives, its own points."""
    if front.shape[1] != 2 or len(front) == 1:
        order = np.argsort(front[:, 0], kind="stable")
        chosen = np.unique(np.linspace(0, len(front) - 1, min(count, len(front))).round().astype(np.int64))
        return front[order][chosen]
    line = front[np.lexsort((-front[:, 1], front[:, 0]))]
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    at = np.linspace(0.0, length[-1], count)
    return np.stack([np.interp(at, length, line[:, k]) for k in (0, 1)], axis=1)
