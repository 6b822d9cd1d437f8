"""The best plan there is, to so many per cent: bounds over plans of whole measurements (theory.md 10.7)."""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.criteria.criterion import known_criteria
from expdesign.design.optimality.certificate import Certificate
from expdesign.design.optimality.columns import Columns, Sites, columns_of, sites_of
from expdesign.design.optimality.outer_approximation import Master, most_sensitive
from expdesign.design.optimality.refinement import Refinement, Result
from expdesign.design.optimality.tree import Tree
from expdesign.design.problem import DesignProblem

GAP = 1e-3
"""Relative distance between a plan and the bound at which branch and bound ends."""
LARGEST = 3000
"""Columns beyond which whole plans are not sought."""
_LIKELY, _MARGIN = 300, 1.3
_RATE, _FIXED = 2.0e6, 10_000.0
"""Entries of linear programs that are worked on in a second, and entries that every program counts as."""


@dataclass(frozen=True)
class WholePlans:
    """How far branch and bound got.

    Attributes:
        bound: what no plan of whole measurements goes below; None where it was not attempted.
        best: the least value of any plan that is known.
        plan: that plan (m, g) where it was found here, else None.
        finished: whether the bound was reached to `GAP`, and not only the end of the time.
        columns: of the last integer program.
        nodes: of all trees.
        words: what was done.
    """

    bound: float | None
    best: float
    plan: FloatArray | None
    finished: bool
    columns: int
    nodes: int
    words: str

    @property
    def gap(self) -> float | None:
        """(best − bound)/bound, or None."""
        return None if not self.bound or not np.isfinite(self.best) else max(self.best / self.bound - 1.0, 0.0)


class BranchAndBound:
    """Bounds over plans of whole measurements.

    Args:
        problem: the design problem.
        certificate: of the relaxation.
        result: of that certificate.
        known: designs (d, m, g) that can be measured.
        seconds: of processor time, as estimated from the work, so that the result does not depend on the machine.
    """

    def __init__(
        self, problem: DesignProblem, certificate: Certificate, result: Result, known: FloatArray | None, seconds: float
    ) -> None:
        self._problem, self._certificate, self._result = problem, certificate, result
        self._name = "total" if certificate.information.load_errors > 0.0 else "duir"
        self._work = seconds * _RATE
        self._nodes = 0
        space = problem.space
        self._free = problem.constraints is None and space.most_poses is None
        self._free &= not space.required.poses and not space.required.masses
        self._best, self._plan = np.inf, None
        if known is not None and len(known):
            self._best = float(np.min(self._values(known)))

    def run(self) -> WholePlans:
        """Bound the whole plans from below as far as the work allows."""
        relaxed, last = self._result.bound.value, self._result.last
        if relaxed is None or last is None:
            return self._not("there is no bound of the relaxation")
        if self._best <= relaxed * (1.0 + GAP):
            return self._found(relaxed, 0, "the relaxation's bound is reached")
        sites = sites_of(self._certificate.information)
        if isinstance(sites, str):
            return self._not(sites)
        for value in (min(self._best, _MARGIN * relaxed), None):
            if value is None and not np.isfinite(self._best):
                return self._not("no plan is known")
            parts = self._columns(sites, last, self._best if value is None else value)
            if isinstance(parts, str):
                return self._not(parts)
            number = sum(len(part) for part in parts)
            if value is not None:
                self._search(most_sensitive(parts, last.dual, _LIKELY), last, relaxed, 0.0)
            elif number > LARGEST:
                return self._not(f"{number} poses with parts of their loads are too many")
        bound = self._search(parts, last, relaxed, self._work)
        return self._found(max(bound, relaxed), number, "")

    def _columns(self, sites: Sites, last: Refinement, value: float) -> list[Columns] | str:
        """Columns that a plan better than `value` can have."""
        dual = last.dual
        threshold = dual.gain**2 / value**2 - dual.prior
        return columns_of(sites, last.count, dual, threshold * (1.0 - 1e-9), last.largest)

    def _search(self, parts: list[Columns], last: Refinement, relaxed: float, work: float) -> float:
        """The bound over plans of these columns and the best known one, and better plans on the way."""
        master = Master(self._certificate.relaxation, parts, relaxed**2)
        if len(master) == 0:
            return self._best
        master.cut(last.dual)
        generator = np.random.default_rng(self._problem.optimiser.seed)
        end = max(0.0, self._work - work)
        bound = relaxed

        def within() -> bool:
            self._work -= _FIXED + master.entries
            return self._work > end

        def attempt(times: FloatArray) -> float:
            self._try(master.plan(times))
            return self._best**2

        while True:
            tree = Tree(master, attempt, 2.0 * GAP, generator)
            outcome = tree.run(self._best**2, within)
            self._nodes += outcome.nodes
            bound = max(bound, min(float(np.sqrt(outcome.bound)), self._best))
            if outcome.loose is None:
                break
            attempt(outcome.loose)
            if work <= 0.0 or not master.refine(outcome.loose) or not within():
                break
        return bound

    def _try(self, measurements: FloatArray) -> None:
        if not self._free:
            return
        plan = self._problem.settable(measurements[None])
        value = float(self._values(plan)[0])
        if value < self._best:
            self._best, self._plan = value, plan[0]

    def _values(self, designs: FloatArray) -> FloatArray:
        found = known_criteria()[self._name].values(self._problem.assess(*self._problem.space.decode(designs)))
        return np.where(np.isfinite(found), found, np.inf)

    def _not(self, why: str) -> WholePlans:
        return WholePlans(None, self._best, None, False, 0, self._nodes, f"not attempted: {why}")

    def _found(self, bound: float, columns: int, words: str) -> WholePlans:
        bound = min(bound, self._best)
        finished = self._best <= bound * (1.0 + GAP)
        text = words or (
            f"branch and bound over {columns} poses with their loads, {self._nodes} nodes"
            f"{'' if finished else ', ended by its time'}"
        )
        return WholePlans(bound, self._best, self._plan, finished, columns, self._nodes, text)


def whole_plan_bound(
    problem: DesignProblem, load_errors: float, known: FloatArray | None, seconds: float
) -> WholePlans:
    """The bound over whole plans of a problem by itself; see `BranchAndBound`."""
    certificate = Certificate(problem, load_errors)
    return BranchAndBound(problem, certificate, certificate.result(known), known, seconds).run()
