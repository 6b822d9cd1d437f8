"""Candidates of a bound that are single measurements, and the search for the most sensitive one (theory.md 10.1)."""

from typing import NamedTuple, Protocol

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.planning.optimality.information import CHUNK, MeasurementInformation
from expdesign.planning.optimality.sqp import MinimaxSearch
from expdesign.planning.optimality.weights import Dual
from expdesign.planning.problem import DesignProblem

ENUMERABLE = 1_000_000
"""Largest number of candidates that are all looked at."""


class Found(NamedTuple):
    """Outcome of a search for the largest d per measurement: where, how large, and in words."""

    candidates: FloatArray
    largest: float
    words: str


class Effort(NamedTuple):
    """How hard a search tries.

    Attributes:
        samples: number of random measurements among the first candidates.
        starts: number of gradient ascents of a round.
        steps: largest number of steps of an ascent.
        passes: largest number of ascents one after the other, each from the best load at the end of the one before.
    """

    samples: int = 6000
    starts: int = 64
    steps: int = 60
    passes: int = 3


THOROUGH, BRIEF = Effort(), Effort(samples=1000, starts=16, steps=15, passes=1)


class Pool(Protocol):
    """Candidates of the relaxation, rows of an array whatever they are.

    Attributes:
        complete: whether the first candidates are all that there are.
    """

    complete: bool

    def first(self, front: FloatArray | None) -> FloatArray:
        """The first candidates; `front` holds designs (d, m, g) that are known."""

    def rows(self, candidates: FloatArray) -> FloatArray:
        """Maps R (j, k, q) with RᵀR the information of a candidate per measurement in it."""

    def largest(self, dual: Dual, candidates: FloatArray, rows: FloatArray, effort: Effort) -> Found:
        """The largest ‖R·Q‖² of all that could be a candidate, and candidates that come near it."""

    def distinct(self, candidates: FloatArray) -> FloatArray:
        """Candidates without those that repeat another to a millionth of the ranges."""

    def measurements(self, candidates: FloatArray, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The single measurements (i, g) of candidates, and their weights (i,)."""

    def caveat(self) -> str:
        """What a bound over these candidates leaves out, or nothing."""


def usable(problem: DesignProblem, variables: FloatArray) -> FloatArray:
    """Those of measurements (j, g) whose poses are within the robot's limits and not singular."""
    keep = np.empty(len(variables), dtype=bool)
    for start in range(0, len(variables), CHUNK):
        part = slice(start, start + CHUNK)
        keep[part] = problem.loaded.robot.usable(problem.space.decode(variables[part])[0])
    return variables[keep]


def enumerated(problem: DesignProblem, fixed: IntArray) -> FloatArray | None:
    """Every usable combination of discrete variables (j, g), 0 for those with the given indices, which may be
    continuous; None where another variable is continuous, or where there are too many.
    """
    space = problem.space
    if np.setdiff1d(np.flatnonzero(~space.discrete & (space.upper > space.lower)), fixed).size:
        return None
    if space.settings is not None:
        fixed = np.union1d(fixed, [space.settings.gene])
    others = np.setdiff1d(np.arange(space.decisions), fixed)
    axes = [np.arange(space.upper[i] + 1.0) if space.discrete[i] else space.lower[[i]] for i in others]
    if float(np.prod([len(axis) for axis in axes])) > ENUMERABLE:
        return None
    grid = np.array(np.meshgrid(*axes, indexing="ij")).reshape(len(axes), -1).T if axes else np.zeros((1, 0))
    variables = np.zeros((len(grid), space.decisions))
    variables[:, others] = grid
    if space.settings is not None:
        variables[:, space.settings.gene] = space.settings.first
    # Whether a measurement can be taken does not depend on its load.
    return usable(problem, variables)


def ascent_words(values: FloatArray, largest: float) -> str:
    """How sure a search was whose ascents ended at these values."""
    reached = values > (1.0 - 1e-5) * largest
    levels, counts = np.unique(np.round(np.log(values), 5), return_counts=True)
    once = int((counts == 1).sum())
    return (
        f"its sensitivity was maximised over the continuous bounds by {len(values)} gradient ascents, of which "
        f"{int(reached.sum())} reached the largest value found; they ended at {len(levels)} different values, "
        f"{once} of them met once, so that an ascent from a new start would end at an unknown maximum with a "
        f"probability of about {once / len(values):.0%} (not a proof over the continuum)"
    )


def promising(order: IntArray, starts: int, generator: np.random.Generator) -> IntArray:
    """Starts of the ascents: the best candidates, and as many from the better half at random."""
    best = order[: starts // 2]
    rest = order[starts // 2 : max(starts, len(order) // 2)]
    others = generator.permutation(rest)[: starts - len(best)]
    return np.concatenate([best, others])


class MeasurementPool:
    """Single measurements as candidates, variables (j, g).

    Args:
        information: maps of single measurements.
        samples: number of random measurements among the first candidates over a continuum.
        given: the only measurements that may be chosen, variables (j, g); the whole design space where left out.
    """

    def __init__(self, information: MeasurementInformation, samples: int, given: FloatArray | None) -> None:
        self._information, self._problem, self._samples = information, information.problem, samples
        self._generator = np.random.default_rng(information.problem.optimiser.seed)
        self._loads = information.load_variables()
        self._given = given is not None
        self._whole = self._enumerated() if given is None else usable(self._problem, given)
        self.complete = self._whole is not None

    def caveat(self) -> str:
        if self._problem.noise.shared_reference:
            return "measurements that share a reference are counted as independent with half the covariance"
        return ""

    def rows(self, candidates: FloatArray) -> FloatArray:
        return self._information.rows(candidates)

    def measurements(self, candidates: FloatArray, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
        return candidates, weights

    def first(self, front: FloatArray | None) -> FloatArray:
        space = self._problem.space
        if self._whole is not None:
            return self._whole
        sampled = space.sample(self._samples, self._generator)
        if self._information.convex_in_load and self._loads.index.size:
            drawn = self._generator.integers(len(self._loads.vertices), size=len(sampled))
            sampled[:, self._loads.index] = self._loads.vertices[drawn]
        parts = [sampled] if front is None else [sampled, front.reshape(-1, space.decisions)]
        return usable(self._problem, np.concatenate(parts))

    def distinct(self, candidates: FloatArray) -> FloatArray:
        space = self._problem.space
        span = np.where(space.upper > space.lower, space.upper - space.lower, 1.0)
        _, first = np.unique(np.round((candidates - space.lower) / span, 6), axis=0, return_index=True)
        return candidates[np.sort(first)]

    def largest(self, dual: Dual, candidates: FloatArray, rows: FloatArray, effort: Effort) -> Found:
        known = dual.sensitivities(rows)
        order = np.argsort(-known, kind="stable")
        if self._whole is not None:
            words = f"its sensitivity was evaluated at all {len(candidates)} measurements"
            if not self._given and self._information.convex_in_load and self._loads.index.size:
                words += " with extreme loads, where it is largest because it is convex in the load"
            return Found(candidates[order[:20]], float(known[order[0]]), words)
        starts = candidates[promising(order, effort.starts, self._generator)]
        return self._ascend(dual, starts, float(known[order[0]]), effort)

    def _enumerated(self) -> FloatArray | None:
        """Every measurement that can be extreme (j, g), where the design space has finitely many; else None."""
        extreme = self._information.convex_in_load
        index = self._loads.index if extreme else np.zeros(0, dtype=np.int64)
        vertices = self._loads.vertices if extreme else np.zeros((1, 0))
        poses = enumerated(self._problem, index)
        if poses is None or len(poses) * len(vertices) > ENUMERABLE:
            return None
        variables = np.repeat(poses[:, None], len(vertices), axis=1)
        variables[..., index] = vertices
        return variables.reshape(-1, poses.shape[1])

    def _ascend(self, dual: Dual, starts: FloatArray, known: float, effort: Effort) -> Found:
        information = self._information
        size = max(known, 1e-300)

        def pieces(variables: FloatArray, index: IntArray) -> tuple[FloatArray, FloatArray]:
            values, gradient = information.sensitivity(dual, variables[:, 0])
            return -values[:, None] / size, -gradient[:, None, None, :] / size

        search = MinimaxSearch(self._problem, pieces)
        variables = self._at_best_load(dual, starts)
        for _ in range(effort.passes):
            ends = search.minimise(variables[:, None], iterations=effort.steps, tolerance=1e-6, inner=1e-4)[:, 0]
            variables = self._at_best_load(dual, ends)
            if np.array_equal(variables[:, self._loads.index], ends[:, self._loads.index]):
                break
        ends = usable(self._problem, variables)
        if len(ends) == 0:
            return Found(starts, known, "no ascent of its sensitivity ended within the robot's limits")
        values = information.sensitivity(dual, ends)[0]
        largest = max(known, float(values.max()))
        order = np.argsort(-values, kind="stable")
        return Found(ends[order], largest, ascent_words(values, largest))

    def _at_best_load(self, dual: Dual, variables: FloatArray) -> FloatArray:
        """The same measurements (b, g), each with the extreme load at which d is largest."""
        if not self._information.convex_in_load or self._loads.index.size == 0:
            return variables
        vertices = self._loads.vertices
        spread = np.repeat(variables[:, None], len(vertices), axis=1)
        spread[..., self._loads.index] = vertices
        flat = spread.reshape(-1, variables.shape[1])
        values = dual.sensitivities(self._information.rows(flat)).reshape(len(variables), -1)
        return spread[np.arange(len(variables)), values.argmax(axis=1)]
