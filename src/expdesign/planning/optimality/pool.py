"""Candidates of a bound: series of measurements, and the search for the most sensitive one (theory.md 10).

A candidate is a series of measurements at one pose that share their reference reading; where references are not shared,
or loads are not convex, a series is a single measurement. It is an array (n, g) of variables, NaN for missing ones.
"""

from typing import NamedTuple

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.mechanics.differentiation import gradient, independent, plain, sum_of_squares
from expdesign.planning.criteria.information import Information
from expdesign.planning.deflection_noise import series_by_pose
from expdesign.planning.optimality.differentiated import to_variables
from expdesign.planning.optimality.measurement_maps import CHUNK, LoadVariables, MeasurementMaps
from expdesign.planning.optimality.series import Multisets, sizes
from expdesign.planning.optimality.sqp import MinimaxSearch
from expdesign.planning.optimality.weights import Dual
from expdesign.planning.problem import DesignProblem

_ENUMERABLE = 1_000_000
"""Candidates that are all looked at, at most."""


class Ascents(NamedTuple):
    """How hard the most sensitive measurement is searched for over a continuum.

    Attributes:
        samples: random measurements among the first candidates.
        starts, steps: gradient ascents of a round, and their steps at most.
        passes: of ascents one after the other, each from the best load at the end of the one before.
    """

    samples: int = 6000
    starts: int = 64
    steps: int = 60
    passes: int = 3


THOROUGH, BRIEF = Ascents(), Ascents(samples=1000, starts=16, steps=15, passes=1)


class Found(NamedTuple):
    """Outcome of a search for the largest d per measurement: where, how large, and in words."""

    candidates: FloatArray
    largest: float
    words: str


def usable(problem: DesignProblem, variables: FloatArray) -> FloatArray:
    """Those of measurements (j, g) whose poses are within the robot's limits and not singular."""
    parts = np.split(variables, range(CHUNK, len(variables), CHUNK))
    return np.concatenate([part[problem.loaded.robot.usable(problem.space.decode(part)[0])] for part in parts])


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
    if float(np.prod([len(axis) for axis in axes])) > _ENUMERABLE:
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
        f"probability of about {100.0 * once / len(values):.0f} % (not a proof over the continuum)"
    )


def takes_series(information: MeasurementMaps) -> bool:
    """Whether a problem's measurements share references in a way that candidates may be series.

    A measurement is then a pose and a load, and what a series tells is convex in each load.
    """
    problem = information.problem
    space = problem.space
    index = information.load_variables().index
    return (
        problem.noise.shared_reference
        and information.convex_in_load
        and bool((space.of_pose | np.isin(np.arange(space.decisions), index)).all())
    )


class Pool:
    """Candidates of the relaxation, variables (j, n, g).

    Args:
        information: maps of single measurements.
        samples: number of random measurements among the first candidates over a continuum.

    Attributes:
        complete: whether the first candidates are all that there are.
        multisets: the series at a pose, by the extreme loads of their measurements.
    """

    def __init__(self, information: MeasurementMaps, samples: int) -> None:
        self._problem, self._information, self._samples = information.problem, information, samples
        space = self._problem.space
        self._generator = np.random.default_rng(self._problem.optimiser.seed)
        self._shared = takes_series(information)
        self._loads = information.load_variables()
        if not information.convex_in_load:
            self._loads = LoadVariables(np.zeros(0, dtype=np.int64), np.zeros((1, 0)))
        self._moves = ~np.isin(np.arange(space.decisions), self._loads.index)
        vertices = len(self._loads.vertices)
        self._poses = enumerated(self._problem, self._loads.index)
        if self._poses is not None and not self._shared and len(self._poses) * vertices > _ENUMERABLE:
            self._poses = None
        self.complete = self._poses is not None and not self._shared
        poses = samples if self._poses is None else len(self._poses)
        self.multisets = Multisets(vertices, space.measurements if self._shared else 1, poses)
        self._maps: FloatArray | None = None

    def caveat(self) -> str:
        """What a bound over these candidates leaves out, or nothing."""
        if self._problem.noise.shared_reference and not self._shared:
            return "measurements that share a reference are counted as independent with half the covariance"
        return ""

    def first(self, front: FloatArray | None) -> FloatArray:
        """The first candidates: all, or random series of every length and those of known designs (d, m, g)."""
        if self.complete and self._poses is not None:
            return self._options(self._poses).reshape(-1, 1, self._poses.shape[1])
        parts = []
        for members in self.multisets.members:
            poses = self._drawn(400 if self._shared else self._samples)
            parts.append(self._series(poses, members[self._generator.integers(len(members), size=len(poses))]))
        if front is not None:
            parts.append(
                self._of_designs(front) if self._shared else usable(self._problem, np.concatenate(front))[:, None]
            )
        return np.concatenate(parts)

    def maps(self, variables: FloatArray) -> FloatArray:
        """[R, H] (..., k, q + s) of measurements with variables (..., g), H of a shared reference's reading; zero for
        missing ones.
        """
        flat = variables.reshape(-1, variables.shape[-1])
        there = ~np.isnan(flat[:, 0])
        found = self._information.rows(flat[there], reference=self._shared)
        if not there.all():
            rows = np.zeros((len(flat), *found.shape[1:]))
            rows[there] = found
            found = rows
        return found.reshape(*variables.shape[:-1], *found.shape[1:])

    def rows(self, candidates: FloatArray) -> FloatArray:
        """Maps R (j, r, q) with RᵀR the information of a candidate per measurement in it, N_s/n of a series."""
        rows, k = self.maps(candidates), len(self._problem.noise.axes)
        if not self._shared:
            return rows[:, 0]
        stacked = rows.reshape(len(candidates), -1, rows.shape[-1])
        left = Information.beside(stacked[..., :-k], stacked[..., -k:], np.full(k, np.sqrt(2.0)))
        return left.root / np.sqrt(sizes(candidates))[:, None, None]

    def sensitivity(self, dual: Dual, candidates: FloatArray) -> tuple[FloatArray, FloatArray]:
        """‖R·Q‖² (b,) of candidates (b, n, g), and its gradient with respect to the variables of their first
        measurement, (b, g), which the others follow; 0 for loads that only matter at their extremes.
        """
        q, there = dual.matrix.shape[0], ~np.isnan(candidates[..., 0])
        share = (there / there.sum(axis=1, keepdims=True)).reshape(-1)
        quantities = self._problem.space.quantities(np.where(there[..., None], candidates, candidates[:, :1]))
        flat = independent(quantities.reshape(-1, quantities.shape[-1]))
        rest: FloatArray | float = 0.0
        with np.errstate(all="ignore"):
            rows = self._information.of_quantities(flat, reference=self._shared)
            missed = rows[..., :q] @ dual.matrix
            if self._shared:
                numbers = plain(rows).reshape(*there.shape, *rows.shape[1:]) * there[..., None, None]
                # The reference that tells least: at its best value the derivative needs no change of it.
                turned = np.einsum("bnki,bnkr->bir", numbers[..., q:], numbers[..., :q] @ dual.matrix)
                gram = np.einsum("bnki,bnkj->bij", numbers[..., q:], numbers[..., q:])
                reference = np.linalg.solve(2.0 * np.eye(gram.shape[-1]) + gram, turned)
                spread = np.repeat(reference[:, None], there.shape[1], axis=1).reshape(-1, *reference.shape[1:])
                missed = missed - rows[..., q:] @ spread
                rest = 2.0 * (reference**2).sum(axis=(1, 2)) / there.sum(axis=1)
            found = sum_of_squares(missed, (1, 2))
        values: FloatArray = (plain(found) * share).reshape(there.shape).sum(axis=1) + rest
        by_quantities = gradient(found, share, flat).reshape(*there.shape, -1)
        return values, np.where(self._moves, to_variables(self._problem, by_quantities.sum(axis=1)), 0.0)

    def measurements(self, candidates: FloatArray, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The single measurements (i, g) of candidates, and their weights (i,)."""
        there = ~np.isnan(candidates[..., 0])
        shares = np.broadcast_to((weights / there.sum(axis=1))[:, None], there.shape)
        return candidates[there], shares[there]

    def distinct(self, candidates: FloatArray) -> FloatArray:
        """Candidates without those that repeat another to a millionth of the ranges."""
        space = self._problem.space
        scaled = np.round((candidates - space.lower) / space.span, 6)
        flat = np.nan_to_num(scaled, nan=-1.0).reshape(len(candidates), -1)
        _, first = np.unique(flat, axis=0, return_index=True)
        return candidates[np.sort(first)]

    def largest(self, dual: Dual, candidates: FloatArray, rows: FloatArray, effort: Ascents) -> Found:
        """The largest ‖R·Q‖² of all that could be a candidate, and candidates that come near it."""
        known = dual.sensitivities(rows)
        order = np.argsort(-known, kind="stable")
        if self._poses is not None:
            return self._everything(dual, candidates[order[:1]], float(known[order[0]]), self._poses)
        # The best candidates, and as many from the better half at random.
        best, rest = np.split(order, [effort.starts // 2])
        rest = rest[: max(effort.starts, len(order) // 2) - len(best)]
        chosen = np.concatenate([best, self._generator.permutation(rest)[: effort.starts - len(best)]])
        return self._ascend(dual, candidates[chosen], float(known[order[0]]), effort)

    def _everything(self, dual: Dual, best: FloatArray, known: float, poses: FloatArray) -> Found:
        """The largest of all, where these are finitely many poses (p, g); `best` of the candidates has `known`."""
        extreme = " with extreme loads, where it is largest because it is convex in {} load" * bool(
            self._loads.index.size
        )
        if self.complete:
            words = f"its sensitivity was evaluated at all {len(poses) * len(self._loads.vertices)} measurements"
            return Found(best, known, words + extreme.format("the"))
        if self._maps is None:
            self._maps = self.maps(self._options(poses))
        found = self.multisets.best(dual, self._maps)
        order = np.argsort(-found.values, kind="stable")[:40]
        words = (
            f"the sensitivity of a series (measurements at one pose with one reference) was evaluated at all "
            f"{len(poses)} poses for all series of up to {self.multisets.longest} measurements"
        )
        words += extreme.format("every")
        if self.multisets.longest < self._problem.space.measurements:
            words += ", and bounded for longer ones"
        return Found(self._series(poses[order], found.chosen[order]), float(found.bound.max()), words)

    def _ascend(self, dual: Dual, starts: FloatArray, known: float, effort: Ascents) -> Found:
        size = max(known, 1e-300)
        reached, bound = self._at_best_loads(dual, starts[:, 0])

        def pieces(variables: FloatArray, index: IntArray) -> tuple[FloatArray, FloatArray]:
            values, slopes = self.sensitivity(dual, self._moved(reached[index], variables[:, 0]))
            return -values[:, None] / size, -slopes[:, None, None, :] / size

        search = MinimaxSearch(self._problem, pieces)
        for _ in range(effort.passes):
            ends = search.minimise(
                reached[:, :1].copy(), iterations=effort.steps, tolerance=1e-8 if self._shared else 1e-6, inner=1e-4
            )[:, 0]
            before = self._moved(reached, ends)[..., self._loads.index]
            reached, bound = self._at_best_loads(dual, ends)
            if np.array_equal(before, reached[..., self._loads.index], equal_nan=True):
                break
        keep = self._problem.loaded.robot.usable(self._problem.space.decode(reached[:, 0])[0])
        if not keep.any():
            return Found(starts, known, "no ascent of its sensitivity ended within the robot's limits")
        reached, bound = reached[keep], bound[keep]
        values = self.sensitivity(dual, reached)[0]
        order = np.argsort(-values, kind="stable")
        words = ascent_words(values, max(known, float(values.max())))
        return Found(reached[order], max(known, float(bound.max()), float(values.max())), words)

    def _drawn(self, count: int) -> FloatArray:
        """Poses (p, g), as many or fewer."""
        if self._poses is not None:
            return self._poses[self._generator.integers(len(self._poses), size=count * bool(len(self._poses)))]
        sampled = self._problem.space.sample(max(count, self._samples), self._generator)
        return usable(self._problem, sampled)[:count]

    def _options(self, poses: FloatArray) -> FloatArray:
        """The measurements with extreme loads at poses (p, g), shape (p, v, g)."""
        options = np.repeat(poses[:, None], len(self._loads.vertices), axis=1)
        options[..., self._loads.index] = self._loads.vertices
        return options

    def _series(self, poses: FloatArray, members: IntArray) -> FloatArray:
        """Series (p, n, g) at poses (p, g) of vertices of the loads (p, n'), −1 for missing ones."""
        series = np.full((len(poses), self.multisets.longest, poses.shape[1]), np.nan)
        part = np.repeat(poses[:, None], members.shape[1], axis=1)
        part[..., self._loads.index] = self._loads.vertices[members]
        part[members < 0] = np.nan
        series[:, : members.shape[1]] = part
        return series

    def _moved(self, candidates: FloatArray, first: FloatArray) -> FloatArray:
        """Candidates whose first measurement is moved to variables (b, g), and the others with it."""
        return np.where(self._moves & ~np.isnan(candidates[..., :1]), first[:, None], candidates)

    def _at_best_loads(self, dual: Dual, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The most sensitive candidates at the poses of measurements (b, g), and what none there exceeds, (b,)."""
        best = self.multisets.best(dual, self.maps(self._options(poses)))
        return self._series(poses, best.chosen), best.bound

    def _of_designs(self, designs: FloatArray) -> FloatArray:
        """The series of designs (d, m, g) that are short enough to be candidates."""
        space = self._problem.space
        numbers = series_by_pose(space.placed(space.quantities(designs)))
        found = []
        for design, series in zip(designs, numbers, strict=True):
            for number in range(1, int(series.max()) + 1):
                members = design[series == number]
                if len(members) <= self.multisets.longest:
                    padded = np.full((self.multisets.longest, design.shape[-1]), np.nan)
                    padded[: len(members)] = members
                    found.append(padded)
        return self.distinct(np.array(found)) if found else np.zeros((0, self.multisets.longest, designs.shape[-1]))
