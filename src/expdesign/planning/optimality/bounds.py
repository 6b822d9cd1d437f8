"""What no plan goes below: the bound of the convex relaxation and, where it is asked for, of halved boxes
(theory.md 10).

Bounds on `total` are of the best linear unbiased estimator, plans are judged by least squares: these weigh every
reading by the instrument's noise alone. The generalised least squares of Aitken (1936) count the load errors as well,
which is to estimate those that all measurements share along with the compliances, and the reference that a series
shares (theory.md 10.4, 10.6).
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.accuracy import expected_total
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.criteria.information import Information
from expdesign.planning.optimality.certificate import Certificate, LowerBound
from expdesign.planning.optimality.pool import usable
from expdesign.planning.optimality.region_tree import RegionTree
from expdesign.planning.optimality.regions import Regions
from expdesign.planning.options import HALVING
from expdesign.planning.problem import DesignProblem


@dataclass(frozen=True)
class CriterionBounds:
    """What no plan goes below, of DUIR or of `total`.

    Attributes:
        lower: the largest bound that is known.
        best: the least value of any plan that is known; infinite where none is.
        plan: that plan (m, g) where halving met it, else None.
        halved: the bound of halved boxes; None where they were not asked for or not affordable.
        nodes: of the halving.
        exact: whether the bound is a proof, and does not rest on second differences through boxes of poses.
        words: what was done beside the relaxation.
    """

    lower: LowerBound
    best: float
    plan: FloatArray | None = field(default=None, compare=False)
    halved: float | None = None
    nodes: int = 0
    exact: bool = True
    words: str = "not asked for"

    @property
    def open(self) -> float | None:
        """By how much of the bound the best plan known is above it: no plan that is better is so by more; or None."""
        value = self.lower.value
        return max(self.best / value - 1.0, 0.0) if value and np.isfinite(self.best) else None

    @property
    def finished(self) -> bool:
        """Whether the best plan known is the best there is, to `HALVING.gap`."""
        return self.open is not None and self.open <= HALVING.gap

    @property
    def record(self) -> dict[str, Any]:
        """For `run.json` (file-formats.md, run.json)."""
        return {
            "lower_bound": self.halved,
            "least_known": float(self.best) if np.isfinite(self.best) else None,
            "finished": self.finished,
            "exact": self.exact,
            "nodes": self.nodes,
            "how": self.words,
            "open": self.open,
        }


def criterion_bounds(
    problem: DesignProblem,
    load_errors: float,
    known: FloatArray | None,
    seconds: float | None = None,
    ended: Callable[[], bool] = lambda: False,
) -> CriterionBounds:
    """The bounds of DUIR (`load_errors` 0) or of `total` (1) over all plans of as many measurements.

    Args:
        problem: the design problem.
        load_errors: see `MeasurementMaps`.
        known: designs (d, m, g) that can be measured.
        seconds: of halving boxes, of a processor, as estimated from the work; the configuration's where left out.
        ended: whether there is no more time.
    """
    certificate = Certificate(problem, load_errors)
    relaxed = certificate.bound(known, ended)
    halving = _Halving(problem, certificate, known)
    seconds = problem.optimiser.bound_seconds if seconds is None else seconds
    found = CriterionBounds(relaxed, halving.best)
    if relaxed.value is not None and seconds > 0.0 and not found.finished and not ended():
        found = halving.run(relaxed, seconds)
    return _priced(problem, found, load_errors, known)


class _Halving:
    """Boxes of measurements, halved (`region_tree.py`), and the plans met on the way."""

    def __init__(self, problem: DesignProblem, certificate: Certificate, known: FloatArray | None) -> None:
        self._problem, self._certificate = problem, certificate
        self._criterion = known_criteria()[certificate.name.lower()]
        self.best, self._plan = np.inf, None
        space = problem.space
        self._free = problem.constraints is None and problem.budget is None
        self._free &= not space.required.poses and not space.required.masses
        if known is not None and len(known):
            self.best = float(self._values(known).min())

    def run(self, relaxed: LowerBound, seconds: float) -> CriterionBounds:
        """The bound that so much work gives."""
        assert relaxed.value is not None
        if self._problem.noise.shared_reference:
            return CriterionBounds(relaxed, self.best, words="not attempted: measurements share references")
        regions = Regions(self._certificate.information)
        tree = RegionTree(regions, self._certificate.relaxation, self._measurable)
        if not np.isfinite(self.best) or not tree.affordable(seconds):
            return CriterionBounds(relaxed, self.best, words="not attempted: too many corners for the time")
        halved = min(float(np.sqrt(tree.run(self.best**2, 1.9 * HALVING.gap, seconds))), self.best)
        rests = "" if regions.convex else ", where second differences tell how far from linear the sensitivity is"
        words = f"boxes of measurements halved{rests}, {tree.nodes} nodes"
        value = max(relaxed.value, halved)
        lower = LowerBound(value, f"{relaxed.certified_on}; {words}")
        exact = regions.convex or halved <= relaxed.value
        return CriterionBounds(lower, self.best, self._plan, halved, tree.nodes, exact, words)

    def _measurable(self, measurements: FloatArray) -> float:
        """The least value known, squared, once a plan was tried if all of it can be measured."""
        if self._free and len(usable(self._problem, measurements)) == len(measurements):
            plan = self._problem.settable(measurements[None])
            value = float(self._values(plan)[0])
            if value < self.best:
                self.best, self._plan = value, plan[0]
        return self.best**2

    def _values(self, designs: FloatArray) -> FloatArray:
        found = self._criterion.values(self._problem.assessed(designs))
        return np.where(np.isfinite(found), found, np.inf)


def _priced(
    problem: DesignProblem, found: CriterionBounds, load_errors: float, known: FloatArray | None
) -> CriterionBounds:
    """The same, of `total` with what least squares lose against the estimator that the bound is of."""
    value = found.lower.value
    if value is None or load_errors == 0.0 or known is None or not np.isfinite(found.best) or found.best <= value:
        return found
    plan = found.plan
    if plan is None:
        totals = known_criteria()["total"].values(problem.assessed(known))
        plan = known[int(np.nanargmin(totals))]
    reached = best_linear_total(problem, plan)
    price = (
        f"the best plan known is {found.best / value - 1.0:.2%} above it, and would be {reached / value - 1.0:.2%} "
        "above it with the best linear estimator: the rest is what least squares lose, which do not weigh load errors"
    )
    lower = LowerBound(value, f"{found.lower.certified_on}; {price}")
    return CriterionBounds(lower, found.best, found.plan, found.halved, found.nodes, found.exact, found.words)


def best_linear_total(problem: DesignProblem, design: FloatArray) -> float:
    """`total` of a design (m, g) by the best linear unbiased estimator; infinite where it identifies too little."""
    assessment = problem.assessed(design[None])
    errors = assessment.whitened_errors[0]
    known = Information.beside(assessment.whitened[0], errors, np.ones(errors.shape[1]))
    return float(expected_total(known, problem.targets))
