"""Lower bounds that no plan can beat: how far a design is from the best possible (theory.md 10).

The convex relaxation over weighted candidates (`weights.py`) gives, for any Q, a bound that needs one number from the
design space: the largest sensitivity d = ‖R·Q‖² of any measurement in it. The candidates are refined until the bound
meets the relaxation's optimum. Over finitely many candidates the largest d is found by looking at all of them. Over a
continuum it is sought by many gradient ascents, which is not a proof: the text that comes with a bound says so, and how
sure the search was.
"""

from collections.abc import Iterator

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.design.optimality.information import MeasurementInformation
from expdesign.design.optimality.measurement_pool import THOROUGH, Effort, MeasurementPool, Pool
from expdesign.design.optimality.refinement import LowerBound, Refinement, Result
from expdesign.design.optimality.series_pool import SeriesPool, takes_series
from expdesign.design.optimality.split_plans import PARTS, split_duir
from expdesign.design.optimality.weights import Relaxation, dual_of, optimal_weights
from expdesign.design.problem import DesignProblem

TOLERANCE = 1e-4
"""Relative gap of the squared criterion at which the refinement of candidates ends."""
_ROUNDS, _SHORTLIST = 25, 2000
_FINEST = 1e-9
"""Tolerance of the relaxation at which it is not made finer where a round did not improve the bound."""


def duir_lower_bound(problem: DesignProblem, front: FloatArray | None = None) -> LowerBound:
    """Lower bound on DUIR over all plans of as many measurements as the configuration has.

    Args:
        problem: the design problem.
        front: designs (d, m, g) that are known; their measurements are among the candidates.
    """
    return with_split(problem, Certificate(problem, 0.0).result(front), 0.0)


def with_split(problem: DesignProblem, result: Result, load_errors: float) -> LowerBound:
    """The bound of a result, that of DUIR with what plans of split measurements reach (`split_plans.py`)."""
    bound, last = result
    if load_errors > 0.0 or bound.value is None or last is None or not last.needs_parts:
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


class Certificate:
    """The refinement of candidates for one bound.

    Args:
        problem: the design problem.
        load_errors: see `MeasurementInformation`.
        effort: of the search for the largest d over a continuum.
        tolerance: of the relaxation over the present candidates, relative to the criterion squared.
        candidates: the only measurements that may be chosen, variables (j, g); the whole design space where left out.
    """

    def __init__(
        self,
        problem: DesignProblem,
        load_errors: float,
        effort: Effort = THOROUGH,
        tolerance: float = 1e-6,
        candidates: FloatArray | None = None,
    ) -> None:
        self._problem, self._tolerance = problem, tolerance
        self.information = MeasurementInformation(problem, load_errors)
        self.relaxation: Relaxation = self.information.relaxation()
        self.pool: Pool = (
            SeriesPool(self.information, effort)
            if candidates is None and takes_series(self.information)
            else MeasurementPool(self.information, effort, candidates)
        )

    @property
    def name(self) -> str:
        """Of the criterion."""
        return "total" if self.information.load_errors > 0.0 else "DUIR"

    def bound(self, front: FloatArray | None) -> LowerBound:
        """The best bound of the refinement; see `duir_lower_bound` for `front`."""
        return self.result(front).bound

    def result(self, front: FloatArray | None) -> Result:
        """The best bound of the refinement and its last round."""
        if self._problem.loaded.regressor.redundant:
            words = "not computed, nor are designs refined by gradients: unknown frames make parameters redundant"
            return Result(LowerBound(None, words), None)
        if not (self.relaxation.targets != 0.0).any():
            return Result(LowerBound(None, "no axis of any target has a tolerance"), None)
        best, words, gap, last = 0.0, "", np.inf, None
        for last in self.refine(front, _ROUNDS):
            if last.bound > best:
                best, words = last.bound, last.words
            gap = 1.0 - best / last.value
            if gap <= TOLERANCE or self.pool.complete:
                break
        if last is None:
            return Result(LowerBound(None, "no measurement within the robot's limits was found"), None)
        # Rounding in d and in the traces is below 1e-9 of the bound.
        return Result(LowerBound(float(np.sqrt(best * (1.0 - 1e-9))), self._text(words, gap, last)), last)

    def refine(self, front: FloatArray | None, rounds: int) -> Iterator[Refinement]:
        """Solve the relaxation over candidates, search for better ones, add them, and so on."""
        pool = self.pool
        candidates = pool.first(front)
        candidates = candidates if pool.complete else pool.distinct(candidates)
        known: FloatArray | None = None
        tolerance, best = self._tolerance, 0.0
        rows = pool.rows(candidates) if len(candidates) else np.zeros((0, 1, 1))
        for _ in range(rounds if len(candidates) else 0):
            weights = optimal_weights(self.relaxation, rows, tolerance, known)
            support = np.flatnonzero(weights.candidates > 0.0)
            dual = dual_of(self.relaxation, rows[support], weights.candidates[support], weights.mixture)
            found = pool.largest(dual, candidates, rows)
            bound = dual.bound(found.largest)
            # Near singular information Q hangs on weights that hardly count for the value.
            tolerance = tolerance if bound > best else max(0.1 * tolerance, _FINEST)
            best = max(bound, best)
            sensitivities = dual.sensitivities(rows)
            sensitivities[support] = np.inf
            listed = np.argsort(-sensitivities, kind="stable")[:_SHORTLIST]
            yield Refinement(
                *pool.measurements(candidates[listed], weights.candidates[listed]),
                weights.value,
                bound,
                found.words,
                self.relaxation.count,
                dual,
                found.largest,
            )
            if pool.complete:
                continue
            # Candidates that are far from mattering are dropped, so that the pool stays small.
            candidates = pool.distinct(np.concatenate([candidates[listed], found.candidates]))
            rows = pool.rows(candidates)
            # None of the listed ones repeats another.
            known = np.zeros(len(candidates))
            known[: len(listed)] = weights.candidates[listed]

    def _text(self, words: str, gap: float, last: Refinement) -> str:
        m = self._problem.space.measurements
        parts = [
            f"{self.name} of every plan of {m} measurement{'s' if m > 1 else ''}, by the dual of the convex relaxation "
            f"(repeated measurements allowed, weights continuous); {words}"
        ]
        if self.pool.caveat():
            parts.append(self.pool.caveat())
        if self.information.load_errors > 0.0:
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
