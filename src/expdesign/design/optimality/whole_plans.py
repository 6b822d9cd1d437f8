"""The best plan there is, to so many per cent: bounds over plans of whole measurements (theory.md 10.7)."""

from dataclasses import dataclass
from itertools import combinations_with_replacement
from math import comb
from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.criteria.criterion import known_criteria
from expdesign.design.optimality.best_linear import best_linear_total
from expdesign.design.optimality.certificate import Certificate, with_split
from expdesign.design.optimality.columns import Columns, Sites, columns_of, sites_of
from expdesign.design.optimality.descents import Pace, pursued
from expdesign.design.optimality.measurement_pool import usable
from expdesign.design.optimality.objectives import Objectives
from expdesign.design.optimality.outer_approximation import Master, most_sensitive
from expdesign.design.optimality.refinement import LowerBound, Refinement, Result
from expdesign.design.optimality.region_tree import RegionTree
from expdesign.design.optimality.regions import Regions
from expdesign.design.optimality.tree import Tree
from expdesign.design.problem import DesignProblem

GAP = 1e-3
"""Relative distance between a plan and the bound at which branch and bound ends."""
LARGEST = 3000
"""Columns beyond which whole plans are not sought."""
_COLUMNS = 0.5
"""Part of the time that is for columns, where poses can be listed; boxes have the rest."""
_LIKELY, _MARGIN = 300, 1.3
_LOOKED_AT = 300_000
"""Columns among which those of better plans are sought, and as many for every second more."""
_PLANS, _TOGETHER = (4_000, 20_000), 5_000
"""Plans that are valued one by one where no others can be better: so many, and as many for every second."""
_DESCENT = Pace(steps=100, tolerance=1e-9, inner=1e-9)
_AGAIN = 0.8
"""Part of the distance from plan to bound that is left when columns are chosen anew."""


@dataclass(frozen=True)
class WholePlans:
    """How far branch and bound got.

    Attributes:
        bound: what no plan of whole measurements goes below; None where it was not attempted.
        best: the least value of any plan that is known.
        plan: that plan (m, g) where it was found here, else None.
        finished: whether the bound was reached to `GAP`, and not only the end of the time.
        columns: of the last integer program, 0 where there was none.
        nodes: of all trees.
        words: what was done.
        exact: whether the bound is a proof, and does not rest on second differences through boxes of poses.
    """

    bound: float | None
    best: float
    plan: FloatArray | None
    finished: bool
    columns: int
    nodes: int
    words: str
    exact: bool = True

    def sentence(self, criterion: str) -> str:
        """What is proved, in words."""
        if self.bound is None or self.gap is None:
            return ""
        if self.finished:
            return f"the best plan there is, to {100.0 * max(self.gap, GAP):.2g} %, has {criterion} {self.best:.5g}"
        return (
            f"the best plan known has {criterion} {self.best:.5g}; one that is better is so by {self.gap:.2%} at most"
        )

    @property
    def record(self) -> dict[str, Any]:
        """For `run.json` (file-formats.md, run.json)."""
        return {
            "lower_bound": self.bound,
            "least_known": float(self.best) if np.isfinite(self.best) else None,
            "gap": self.gap,
            "finished": self.finished,
            "exact": self.exact,
            "columns": self.columns,
            "nodes": self.nodes,
            "poses": None,  # bounds hold for all poses; a written key stays
            "how": self.words,
        }

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
        self._criterion = certificate.name.lower()
        self._seconds, self._given = seconds, seconds
        self._nodes = 0
        space = problem.space
        self._free = problem.constraints is None and space.most_poses is None
        self._free &= not space.required.poses and not space.required.masses
        self._best, self._plan = np.inf, None
        if known is not None and len(known):
            self._best = float(self._values(known).min())

    def run(self) -> WholePlans:
        """Bound the whole plans from below as far as the work allows."""
        relaxed, last = self._result.bound.value, self._result.last
        if relaxed is None or last is None:
            return self._not("there is no bound of the relaxation")
        if self._best <= relaxed * (1.0 + GAP):
            return self._found(relaxed, 0, "the relaxation's bound is reached")
        listed = self._over_columns(relaxed, last)
        bound, number, words = (relaxed, 0, []) if isinstance(listed, str) else listed
        without = self._not(listed) if isinstance(listed, str) else self._found(bound, number, "; ".join(words))
        if self._seconds <= 0.0 or not np.isfinite(self._best) or self._best <= bound * (1.0 + GAP):
            return without
        regions = Regions(self._certificate.information)
        tree = RegionTree(regions, self._certificate.relaxation, self._measurable)
        if not tree.affordable(self._seconds):
            return without
        halved = float(np.sqrt(tree.run(self._best**2, 1.9 * GAP, self._seconds)))
        self._nodes += tree.nodes
        self._descend()
        rests = "" if regions.convex else ", where second differences tell how far from linear the sensitivity is"
        words = [*words, f"boxes of measurements halved{rests}, {tree.nodes} nodes"]
        exact = regions.convex or halved <= bound
        return self._found(max(bound, halved), number, "; ".join(words), exact=exact)

    def _over_columns(self, relaxed: float, last: Refinement) -> tuple[float, int, list[str]] | str:
        """The bound over plans at listed poses, the number of columns and what was done; or why it is not sought."""
        sites = sites_of(self._certificate.information)
        if isinstance(sites, str):
            return sites
        parts = self._columns(sites, last, min(self._best, _MARGIN * relaxed))
        if isinstance(parts, str):
            return parts
        left = self._seconds * (1.0 - _COLUMNS)
        self._seconds -= left
        try:
            self._search(most_sensitive(parts, last.dual, _LIKELY), last, relaxed, 0.0)
            bound, number = relaxed, 0
            while self._seconds > 0.0 or number == 0:
                if not np.isfinite(self._best):
                    return "no plan is known"
                before = self._best
                parts = self._columns(sites, last, before)
                if isinstance(parts, str):
                    return parts
                number = sum(len(part) for part in parts)
                plans = self._every_plan(parts)
                if plans is not None:
                    return self._best, number, [f"all {plans} plans that could be better were valued"]
                if number > LARGEST:
                    return f"{number} poses with parts of their loads are too many"
                # A better plan leaves fewer columns, so that it is worth while to begin again.
                part, ended = self._search(parts, last, relaxed, self._seconds)
                bound = max(bound, part)
                if ended:
                    break
        finally:
            self._seconds += left
        return bound, number, [f"branch and bound over {number} poses with their loads, {self._nodes} nodes"]

    def _columns(self, sites: Sites, last: Refinement, value: float) -> list[Columns] | str:
        """Columns that a plan better than `value` can have."""
        dual = last.dual
        threshold = dual.gain**2 / value**2 - dual.prior
        limit = _LOOKED_AT * (1.0 + self._given)
        return columns_of(sites, last.count, dual, threshold * (1.0 - 1e-9), last.largest, limit)

    def _every_plan(self, parts: list[Columns]) -> int | None:
        """Value all plans of these columns, if they are few; their number, or None.

        The columns that were left out are those of plans which the best linear estimator does not make better than the
        best one known, and least squares are no better: by whatever estimator, the best plan there is is then known.
        """
        if not self._free:
            return None
        found = [part.every_measurement() for part in parts]
        listed = [each for each in found if each is not None]
        if len(listed) < len(found) or not listed:
            return None
        measurements, m = np.unique(np.concatenate(listed), axis=0), self._problem.space.measurements
        number = comb(len(measurements) + m - 1, m) if len(measurements) else 0
        if number > _PLANS[0] + _PLANS[1] * self._given:
            return None
        plans = np.array(list(combinations_with_replacement(range(len(measurements)), m)), dtype=np.int64)
        for start in range(0, number, _TOGETHER):
            designs = self._problem.settable(measurements[plans[start : start + _TOGETHER]])
            values = self._values(designs)
            if values.min() < self._best:
                self._best, self._plan = float(values.min()), designs[int(values.argmin())]
        return number

    def _search(self, parts: list[Columns], last: Refinement, relaxed: float, seconds: float) -> tuple[float, bool]:
        """The bound over plans of these columns and the best known one, with better plans on the way; and whether it
        ended for another reason than that a much better plan was found.
        """
        master = Master(self._certificate.relaxation, parts, relaxed**2)
        if len(master) == 0:
            return self._best, True
        master.cut(last.dual)
        generator = np.random.default_rng(self._problem.optimiser.seed)
        before = self._best

        def within() -> bool:
            return master.work < seconds and self._best > relaxed + _AGAIN * (before - relaxed)

        def attempt(times: FloatArray) -> float:
            self._try(master.plan(times))
            return self._best**2

        outcome = Tree(master, attempt, 1.9 * GAP, generator).run(self._best**2, within)
        self._nodes += outcome.nodes
        bound = max(relaxed, min(float(np.sqrt(outcome.bound)), self._best))
        ended = within() or master.work >= seconds
        self._seconds -= min(master.work, seconds)
        return bound, ended

    def _try(self, measurements: FloatArray) -> None:
        if not self._free:
            return
        plan = self._problem.settable(measurements[None])
        value = float(self._values(plan)[0])
        if value < self._best:
            self._best, self._plan = value, plan[0]

    def _measurable(self, measurements: FloatArray) -> float:
        """The least value known, squared, once a plan was tried if all of it can be measured."""
        if len(usable(self._problem, measurements)) == len(measurements):
            self._try(measurements)
        return self._best**2

    def _descend(self) -> None:
        """Take the plan that was found to the nearest least value, where its measurements can be anywhere."""
        if self._plan is None or self._problem.space.discrete.all():
            return
        start = self._plan[None]
        objectives = Objectives(self._problem, (known_criteria()[self._criterion],))
        weights = np.zeros((1, len(objectives.criteria)))
        weights[:, -1] = 1.0 / self._best
        self._measurable(pursued(objectives, start, np.zeros_like(weights), weights, _DESCENT)[0])

    def _values(self, designs: FloatArray) -> FloatArray:
        found = known_criteria()[self._criterion].values(self._problem.assess(*self._problem.space.decode(designs)))
        return np.where(np.isfinite(found), found, np.inf)

    def _not(self, why: str) -> WholePlans:
        return WholePlans(None, self._best, None, False, 0, self._nodes, f"not attempted: {why}")

    def _found(self, bound: float, columns: int, words: str, *, exact: bool = True) -> WholePlans:
        bound = min(bound, self._best)
        finished = self._best <= bound * (1.0 + GAP)
        ended = "" if finished else ", ended by its time"
        return WholePlans(bound, self._best, self._plan, finished, columns, self._nodes, f"{words}{ended}", exact)


@dataclass(frozen=True)
class CriterionBounds:
    """What no plan goes below.

    Attributes:
        lower: the larger of the two bounds, over plans in parts and over whole ones.
        whole: how far branch and bound got.
    """

    lower: LowerBound
    whole: WholePlans

    @property
    def record(self) -> dict[str, Any]:
        """For `run.json` (file-formats.md, run.json)."""
        return {**self.whole.record, "open": self.open}

    @property
    def open(self) -> float | None:
        """By how much of the bound the best plan known is above it: no plan that is better is so by more; or None."""
        value, best = self.lower.value, self.whole.best
        return max(best / value - 1.0, 0.0) if value and np.isfinite(best) else None


def criterion_bounds(
    problem: DesignProblem, load_errors: float, known: FloatArray | None, seconds: float | None = None
) -> CriterionBounds:
    """The bounds of DUIR (`load_errors` 0) or of `total` (1) over all plans of as many measurements.

    Args:
        problem: the design problem.
        load_errors: see `MeasurementInformation`.
        known: designs (d, m, g) that can be measured.
        seconds: of branch and bound; the configuration's where left out.
    """
    certificate = Certificate(problem, load_errors)
    result = certificate.result(known)
    seconds = problem.optimiser.bound_seconds if seconds is None else seconds
    whole = BranchAndBound(problem, certificate, result, known, seconds).run()
    return CriterionBounds(_lower(problem, certificate, result, whole, known), whole)


def _lower(
    problem: DesignProblem, certificate: Certificate, result: Result, whole: WholePlans, known: FloatArray | None
) -> LowerBound:
    """The larger of the two bounds, and what it was certified on."""
    factor, relaxed = certificate.information.load_errors, result.bound.value
    if relaxed is None or whole.gap is None or whole.bound is None:
        value, words = with_split(problem, result, factor)
    else:
        value = max(relaxed, whole.bound)
        words = f"{result.bound.certified_on}; {whole.words}: {whole.sentence(certificate.name)}"
    if value is None or factor == 0.0 or known is None or not np.isfinite(whole.best) or whole.best <= value:
        return LowerBound(value, words)
    plan = whole.plan
    if plan is None:
        totals = known_criteria()["total"].values(problem.assess(*problem.space.decode(known)))
        plan = known[int(np.nanargmin(totals))]
    reached = best_linear_total(problem, plan)
    price = (
        f"the best plan known is {whole.best / value - 1.0:.2%} above it, and would be {reached / value - 1.0:.2%} "
        "above it with the best linear estimator: the rest is what least squares lose, which do not weigh load errors"
    )
    return LowerBound(value, f"{words}; {price}")
