"""Lower bounds that no plan can beat: how far a design is from the best possible (theory.md 10).

The convex relaxation over weighted candidates (`weights.py`) gives, for any Q, a bound that needs one number from the
design space: the largest sensitivity d = ‖R·Q‖² of any measurement in it. The candidates are refined until the bound
meets the relaxation's optimum. Over finitely many candidates the largest d is found by looking at all of them. Over a
continuum it is sought by many gradient ascents, which is not a proof: the text that comes with a bound says so, and how
sure the search was.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.design.optimality.information import CHUNK, MeasurementInformation
from expdesign.design.optimality.refinement import LowerBound, Refinement, Result
from expdesign.design.optimality.split_plans import PARTS, split_duir
from expdesign.design.optimality.sqp import MinimaxSearch
from expdesign.design.optimality.weights import Dual, Relaxation, dual_of, optimal_weights
from expdesign.design.problem import DesignProblem

TOLERANCE = 1e-4
"""Relative gap of the squared criterion at which the refinement of candidates ends."""
ENUMERABLE = 1_000_000
"""Largest number of candidates that are all looked at."""
_ROUNDS, _SHORTLIST = 25, 2000


def duir_lower_bound(problem: DesignProblem, front: FloatArray | None = None) -> LowerBound:
    """Lower bound on DUIR over all plans of as many measurements as the configuration has.

    Args:
        problem: the design problem.
        front: designs (d, m, g) that are known; their measurements are among the candidates.
    """
    bound, last = Certificate(problem, 0.0).result(front)
    if bound.value is None or last is None or not last.needs_parts:
        return bound
    split = split_duir(problem, last.shortlist, last.weights)
    if split is None:
        return bound
    words = (
        f"if every measurement could be split into {PARTS} with as much less information each, a plan would come "
        f"within {max(split / bound.value - 1.0, 0.0):.2%} of the bound: what else a plan lacks is the price of whole "
        "measurements"
    )
    return LowerBound(bound.value, f"{bound.certified_on}; {words}")


def total_lower_bound(problem: DesignProblem, front: FloatArray | None = None) -> LowerBound:
    """Lower bound on `total`, and so on √(DUIR² + FEIR²) of every plan, by the relaxation of theory.md 10.4."""
    return Certificate(problem, 1.0).bound(front)


@dataclass(frozen=True)
class _Search:
    """Outcome of a search for the largest d: where, how large, and in words."""

    variables: FloatArray
    largest: float
    words: str


class Certificate:
    """The refinement of candidates for one bound.

    Args:
        problem: the design problem.
        load_errors: see `MeasurementInformation`.
        samples: number of random measurements among the first candidates.
        starts: number of gradient ascents of a round.
        steps: largest number of steps of an ascent.
        passes: largest number of ascents one after the other, each from the best load at the end of the one before.
        tolerance: of the relaxation over the present candidates, relative to the criterion squared.
        candidates: the only measurements that may be chosen, variables (j, g); the whole design space where left out.
    """

    def __init__(
        self,
        problem: DesignProblem,
        load_errors: float,
        samples: int = 6000,
        starts: int = 64,
        steps: int = 60,
        passes: int = 3,
        tolerance: float = 1e-7,
        candidates: FloatArray | None = None,
    ) -> None:
        self._problem = problem
        self._steps, self._passes, self._tolerance = steps, passes, tolerance
        self._samples, self._starts = samples, starts
        self._information = MeasurementInformation(problem, load_errors)
        self._relaxation: Relaxation = self._information.relaxation()
        self._generator = np.random.default_rng(problem.optimiser.seed)
        self._loads = self._information.load_variables()
        self._given = candidates is not None
        self._whole = self._enumerated() if candidates is None else self._usable(candidates)

    def bound(self, front: FloatArray | None) -> LowerBound:
        """The best bound of the refinement; see `duir_lower_bound` for `front`."""
        return self.result(front).bound

    def result(self, front: FloatArray | None) -> Result:
        """The best bound of the refinement and its last round."""
        if self._problem.loaded.regressor.redundant:
            words = "not computed, nor are designs refined by gradients: unknown frames make parameters redundant"
            return Result(LowerBound(None, words), None)
        if not (self._relaxation.targets != 0.0).any():
            return Result(LowerBound(None, "no axis of any target has a tolerance"), None)
        best, words, gap, last = 0.0, "", np.inf, None
        for last in self.refine(front, _ROUNDS):
            if last.bound > best:
                best, words = last.bound, last.words
            gap = 1.0 - best / last.value
            if gap <= TOLERANCE:
                break
        if last is None:
            return Result(LowerBound(None, "no measurement within the robot's limits was found"), None)
        # Rounding in d and in the traces is below 1e-9 of the bound.
        return Result(LowerBound(float(np.sqrt(best * (1.0 - 1e-9))), self._text(words, gap, last)), last)

    def refine(self, front: FloatArray | None, rounds: int) -> Iterator[Refinement]:
        """Solve the relaxation over candidates, search for better ones, add them, and so on."""
        candidates = self._candidates(front)
        rows = self._information.rows(candidates) if len(candidates) else np.zeros((0, 1, 1))
        for _ in range(rounds if len(candidates) else 0):
            weights = optimal_weights(self._relaxation, rows, self._tolerance)
            support = np.flatnonzero(weights.candidates > 0.0)
            dual = dual_of(self._relaxation, rows[support], weights.candidates[support], weights.mixture)
            found = self._largest(dual, candidates, rows)
            listed = np.argsort(-np.where(weights.candidates > 0.0, np.inf, dual.sensitivities(rows)), kind="stable")
            yield Refinement(
                candidates[listed[:_SHORTLIST]],
                weights.candidates[listed[:_SHORTLIST]],
                weights.value,
                dual.bound(found.largest),
                found.words,
                self._relaxation.count,
            )
            if self._whole is not None:
                continue
            # Candidates that are far from mattering are dropped, so that the pool stays small.
            sensitivities = dual.sensitivities(rows)
            sensitivities[support] = np.inf
            keep = np.argsort(-sensitivities, kind="stable")[:_SHORTLIST]
            candidates = self._distinct(np.concatenate([candidates[keep], found.variables]))
            rows = self._information.rows(candidates)

    def _text(self, words: str, gap: float, last: Refinement) -> str:
        m = self._problem.space.measurements
        with_errors = self._information.load_errors > 0.0
        quantity = "total" if with_errors else "DUIR"
        parts = [
            f"{quantity} of every plan of {m} measurement{'s' if m > 1 else ''}, by the dual of the convex relaxation "
            f"(repeated measurements allowed, weights continuous); {words}"
        ]
        if self._problem.noise.shared_reference:
            parts.append("measurements that share a reference are counted as independent with half the covariance")
        if with_errors:
            parts.append("load errors are those of the best linear estimator, so that it holds for least squares too")
        parts.append(f"the relaxation's own optimum is at most {50.0 * max(gap, 0.0):.2g} % larger")
        support = last.support
        if last.needs_parts:
            shares = ", ".join(f"{m * weight:.2f}" for weight in support[:8])
            parts.append(
                f"that optimum takes {len(support)} different measurements {shares}{' …' if len(support) > 8 else ''} "
                "times, which a plan of whole measurements can only approach"
            )
        return "; ".join(parts)

    def _usable(self, variables: FloatArray) -> FloatArray:
        usable = np.empty(len(variables), dtype=bool)
        for start in range(0, len(variables), CHUNK):
            part = slice(start, start + CHUNK)
            usable[part] = self._problem.loaded.robot.usable(self._problem.space.decode(variables[part])[0])
        return variables[usable]

    def _enumerated(self) -> FloatArray | None:
        """Every measurement that can be extreme (j, g), where the design space has finitely many; else None."""
        space = self._problem.space
        continuous = np.flatnonzero(~space.discrete)
        if not self._information.convex_in_load and continuous.size:
            return None
        if np.setdiff1d(continuous, self._loads.index).size:
            return None
        extreme = self._information.convex_in_load
        others = np.setdiff1d(np.arange(space.genes), self._loads.index if extreme else [])
        axes = [np.arange(space.upper[variable] + 1.0) for variable in others]
        vertices = self._loads.vertices if extreme else np.zeros((1, 0))
        if float(np.prod([len(axis) for axis in axes])) * len(vertices) > ENUMERABLE:
            return None
        grid = np.array(np.meshgrid(*axes, indexing="ij")).reshape(len(axes), -1).T if axes else np.zeros((1, 0))
        poses = np.zeros((len(grid), space.genes))
        poses[:, others] = grid
        # Whether a measurement can be taken does not depend on its load.
        variables = np.repeat(self._usable(poses)[:, None], len(vertices), axis=1)
        if extreme:
            variables[..., self._loads.index] = vertices
        return variables.reshape(-1, space.genes)

    def _candidates(self, front: FloatArray | None) -> FloatArray:
        space = self._problem.space
        if self._whole is not None:
            return self._whole
        sampled = space.sample(self._samples, self._generator)
        if self._information.convex_in_load and self._loads.index.size:
            drawn = self._generator.integers(len(self._loads.vertices), size=len(sampled))
            sampled[:, self._loads.index] = self._loads.vertices[drawn]
        parts = [sampled] if front is None else [sampled, front.reshape(-1, space.genes)]
        return self._usable(np.concatenate(parts))

    def _largest(self, dual: Dual, candidates: FloatArray, rows: FloatArray) -> _Search:
        known = dual.sensitivities(rows)
        order = np.argsort(-known, kind="stable")
        if self._whole is not None:
            words = f"its sensitivity was evaluated at all {len(candidates)} measurements"
            if not self._given and self._information.convex_in_load and self._loads.index.size:
                words += " with extreme loads, where it is largest because it is convex in the load"
            return _Search(candidates[order[:20]], float(known[order[0]]), words)
        return self._ascend(dual, candidates[self._promising(order)], float(known[order[0]]))

    def _distinct(self, variables: FloatArray) -> FloatArray:
        """Measurements (j, g) without those that repeat another to a millionth of the ranges."""
        space = self._problem.space
        span = np.where(space.upper > space.lower, space.upper - space.lower, 1.0)
        _, first = np.unique(np.round((variables - space.lower) / span, 6), axis=0, return_index=True)
        return variables[np.sort(first)]

    def _promising(self, order: IntArray) -> IntArray:
        """Starts of the ascents: the best candidates, and as many from the better half at random."""
        best = order[: self._starts // 2]
        rest = order[self._starts // 2 : max(self._starts, len(order) // 2)]
        others = self._generator.permutation(rest)[: self._starts - len(best)]
        return np.concatenate([best, others])

    def _ascend(self, dual: Dual, starts: FloatArray, known: float) -> _Search:
        information = self._information
        size = max(known, 1e-300)

        def pieces(variables: FloatArray, index: IntArray) -> tuple[FloatArray, FloatArray]:
            values, gradient = information.sensitivity(dual, variables[:, 0])
            return -values[:, None] / size, -gradient[:, None, None, :] / size

        search = MinimaxSearch(self._problem, pieces)
        variables = self._at_best_load(dual, starts)
        for _ in range(self._passes):
            ends = search.minimise(variables[:, None], iterations=self._steps, tolerance=1e-8)[:, 0]
            variables = self._at_best_load(dual, ends)
            if np.array_equal(variables[:, self._loads.index], ends[:, self._loads.index]):
                break
        ends = self._usable(variables)
        if len(ends) == 0:
            return _Search(starts, known, "no ascent of its sensitivity ended within the robot's limits")
        values = information.sensitivity(dual, ends)[0]
        largest = max(known, float(values.max()))
        reached = values > (1.0 - 1e-5) * largest
        levels, counts = np.unique(np.round(np.log(values), 5), return_counts=True)
        once = int((counts == 1).sum())
        words = (
            f"its sensitivity was maximised over the continuous bounds by {len(ends)} gradient ascents, of which "
            f"{int(reached.sum())} reached the largest value found; they ended at {len(levels)} different values, "
            f"{once} of them met once, so that an ascent from a new start would end at an unknown maximum with a "
            f"probability of about {once / len(ends):.0%} (not a proof over the continuum)"
        )
        order = np.argsort(-values, kind="stable")
        return _Search(ends[order], largest, words)

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
