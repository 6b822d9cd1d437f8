"""Lower bounds that no plan can beat: how far a design is from the best possible (theory.md 10).

The convex relaxation over weighted candidates (`weights.py`) gives, for any Q, a bound that needs one number from the
design space: the largest sensitivity d = ‖R·Q‖² of any measurement in it. The candidates are refined until the bound
meets the relaxation's optimum. Over finitely many candidates the largest d is found by looking at all of them. Over a
continuum it is sought by many gradient ascents, which is not a proof: the text that comes with a bound says so, and how
sure the search was.

Bounds on `total` are of generalised least squares (`experiment.estimator`, theory.md 10.4, 10.6), the best linear
unbiased estimator. They hold for weighted least squares too, which come less close to them.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.estimation.load_errors import Estimator
from expdesign.planning.optimality.measurement_maps import MeasurementMaps
from expdesign.planning.optimality.pool import BRIEF, THOROUGH, Ascents, Pool
from expdesign.planning.optimality.weights import Relaxation, optimal_weights
from expdesign.planning.problem import DesignProblem

_GAP = 1e-3
"""Relative, of the squared criterion, at which the refinement of candidates ends."""

_OF_ESTIMATOR: dict[Estimator, str] = {
    "generalised": "the estimator is generalised least squares, as the configuration has it",
    "weighted": "the estimator is generalised least squares, the best linear one, and the configuration has weighted "
    "least squares, which do not weigh load errors and reach it less closely",
}


class LowerBound(NamedTuple):
    """A number that no plan can beat (None where there is none), and what it was certified on, in words."""

    value: float | None
    certified_on: str


@dataclass(frozen=True)
class Refinement:
    """One round.

    Attributes:
        shortlist: candidates with weight, and the most sensitive of the others, shape (j, g).
        weights: of the shortlist, shape (j,).
        value: optimum of the relaxation over the candidates so far, the criterion squared.
        bound: lower bound over the whole design space, the criterion squared.
        words: how the largest sensitivity was found.
    """

    shortlist: FloatArray
    weights: FloatArray
    value: float
    bound: float
    words: str


class Certificate:
    """The refinement of candidates for one bound.

    Args:
        problem: the design problem.
        load_errors: see `MeasurementMaps`.
        effort: of the searches for the largest d over a continuum on which a bound rests.
        tolerance: of the relaxation over the present candidates, relative to the criterion squared.
    """

    def __init__(
        self,
        problem: DesignProblem,
        load_errors: float,
        effort: Ascents = THOROUGH,
        tolerance: float = 1e-6,
    ) -> None:
        self._problem, self._effort, self._tolerance = problem, effort, tolerance
        self.information = MeasurementMaps(problem, load_errors)
        self.relaxation: Relaxation = self.information.relaxation()
        self.pool = Pool(self.information, effort.samples)

    @property
    def name(self) -> str:
        """Of the criterion."""
        return "total" if self.information.load_errors > 0.0 else "DUIR"

    def bound(self, front: FloatArray | None = None, ended: Callable[[], bool] = lambda: False) -> LowerBound:
        """The best bound of the refinement, over all plans of as many measurements as the configuration has.

        Args:
            front: designs (d, m, g) that are known; their measurements are among the candidates.
            ended: whether there is no more time, asked after every round.
        """
        if self._problem.loaded.regressor.redundant:
            words = "not computed, nor are designs refined by gradients: unknown frames make parameters redundant"
            return LowerBound(None, words)
        if not (self.relaxation.targets != 0.0).any():
            return LowerBound(None, "no axis of any target has a tolerance")
        best, words, gap, last = 0.0, "", np.inf, None
        for last in self.refine(front, 25, ended):
            if last.bound > best:
                best, words = last.bound, last.words
            gap = 1.0 - best / last.value
            if gap <= _GAP or self.pool.complete or ended():
                break
        if last is None:
            return LowerBound(None, "no measurement within the robot's limits was found")
        if best == 0.0:
            return LowerBound(None, "not computed: the run was ended before")
        # Rounding in d and in the traces is below 1e-9 of the bound.
        return LowerBound(float(np.sqrt(best * (1.0 - 1e-9))), self._text(words, gap, last))

    def refine(
        self, front: FloatArray | None, rounds: int, ended: Callable[[], bool] = lambda: False
    ) -> Iterator[Refinement]:
        """Solve the relaxation over candidates, search for better ones, add them, and so on.

        A brief search is enough to find better candidates. Where it finds none, in the last round, and where `ended`
        says so, a search with all effort follows, on which alone a bound can rest.
        """
        pool = self.pool
        candidates = pool.first(front)
        candidates = candidates if pool.complete else pool.distinct(candidates)
        known: FloatArray | None = None
        tolerance, best = self._tolerance, 0.0
        rows = pool.rows(candidates) if len(candidates) else np.zeros((0, 1, 1))
        for left in reversed(range(rounds if len(candidates) else 0)):
            weights, dual = optimal_weights(self.relaxation, rows, tolerance, known)
            found = pool.largest(dual, candidates, rows, BRIEF)
            closed = dual.bound(found.largest) >= (1.0 - _GAP) * dual.value or left == 0 or ended()
            if closed and self._effort != BRIEF and not pool.complete:
                found = pool.largest(dual, candidates, rows, self._effort)
            bound = dual.bound(found.largest) if closed or pool.complete else 0.0
            # Near singular information Q hangs on weights that hardly count for the value.
            tolerance = tolerance if bound > best else max(0.1 * tolerance, 1e-9)
            best = max(bound, best)
            sensitivities = dual.sensitivities(rows)
            sensitivities[weights > 0.0] = np.inf
            listed = np.argsort(-sensitivities, kind="stable")[:2000]
            shortlist = pool.measurements(candidates[listed], weights[listed])
            yield Refinement(*shortlist, dual.value, bound, found.words)
            if pool.complete:
                continue
            # Candidates that are far from mattering are dropped, so that the pool stays small.
            candidates = pool.distinct(np.concatenate([candidates[listed], found.candidates]))
            rows = pool.rows(candidates)
            # None of the listed ones repeats another.
            known = np.zeros(len(candidates))
            known[: len(listed)] = weights[listed]

    def _text(self, words: str, gap: float, last: Refinement) -> str:
        m = self._problem.space.measurements
        parts = [
            f"{self.name} of every plan of {m} measurement{'s' if m > 1 else ''}, by the dual of the convex relaxation "
            f"(repeated measurements allowed, weights continuous); {words}"
        ]
        if self.pool.caveat():
            parts.append(self.pool.caveat())
        if self.information.load_errors > 0.0:
            parts.append(_OF_ESTIMATOR[self._problem.estimator])
        parts.append(f"the relaxation's own optimum is at most {50.0 * max(gap, 0.0):.2g} % larger")
        times = m * np.sort(last.weights[last.weights > 0.01])[::-1]
        if len(times) > m or np.abs(times - np.rint(times)).max() > 0.1:
            shares = ", ".join(f"{number:.2f}" for number in times[:8])
            parts.append(
                f"that optimum takes {len(times)} different measurements {shares}{' …' if len(times) > 8 else ''} "
                "times, which a plan of whole measurements can only approach"
            )
        return "; ".join(parts)
