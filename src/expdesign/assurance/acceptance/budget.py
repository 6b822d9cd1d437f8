"""The uncertainty budget of the pose that is attained after compensation (JCGM 100:2008, clauses 4, 5 and 8).

The error of the attained pose is −A_D·ε_c (theory.md 4.1), linear in independent inputs: the noise of the deflections
and each source of load error. The combined standard uncertainty along an axis is u_c = √Σ u_i² (5.1.2) and the
expanded one U = k·u_c (6.2.1).
"""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.estimation.coverage import Coverage

if TYPE_CHECKING:  # what is decided of recordings without targets need not wait for planning
    from expdesign.assurance.acceptance.repetition import Repetition
    from expdesign.planning.problem import DesignProblem

NOISE = "noise"
OWN_PAYLOAD = "own payload"
"""Name of what is not known of the payload at a target."""
DRAWING = "drawing"
"""Name of what no reading shows of an arm's tip, as large as this arm is made."""


@dataclass(frozen=True)
class Contribution:
    """One line of a budget.

    Attributes:
        name: `noise`, or the source of load error.
        deviation: standard uncertainty of the attained pose along every axis (m, rad), shape (t, n); NaN where it is
            not determined.
        degrees: degrees of freedom of the estimate of it; infinite where it is known.
        covariance: of the attained poses together (m², m·rad, rad²), shape (t, n, t, n); None where only the axes by
            themselves are known, as of a plan.
    """

    name: str
    deviation: FloatArray
    degrees: float = float("inf")
    covariance: FloatArray | None = None


@dataclass(frozen=True)
class UncertaintyBudget:
    """Contributions at t targets along n axes.

    Attributes:
        contributions: independent of each other.
        tolerance: ± what is accepted (m, rad), shape (t, n), NaN where an axis does not matter.
        axes: deflection columns along the axes.
        coverage: of the expanded uncertainty.
        measurements: of the experiment.
        base: by how much the base's frame may be off where no reading shows its place (m, rad), shape (t, n), one
            standard deviation; no contribution to U, whose frame it is. None where all is shown.
        repetition: how the variances fall when the experiment is repeated; None where that is not known.
    """

    contributions: tuple[Contribution, ...]
    tolerance: FloatArray
    axes: tuple[str, ...]
    coverage: Coverage
    measurements: int
    base: FloatArray | None = None
    repetition: "Repetition | None" = None

    @property
    def matters(self) -> BoolArray:
        """Which axes have a tolerance, shape (t, n)."""
        matters: BoolArray = np.isfinite(self.tolerance)
        return matters

    def of(self, name: str) -> Contribution | None:
        """The first contribution of a name; None where there is none."""
        return next((one for one in self.contributions if one.name == name), None)

    @cached_property
    def standard(self) -> FloatArray:
        """u_c (m, rad), shape (t, n)."""
        return np.sqrt(np.sum([one.deviation**2 for one in self.contributions], axis=0))

    @cached_property
    def degrees(self) -> FloatArray:
        """ν_eff of Welch and Satterthwaite (JCGM 100:2008, G.2b), shape (t, n)."""
        parts = [one.deviation**4 / one.degrees for one in self.contributions]
        with np.errstate(divide="ignore", invalid="ignore"):
            degrees: FloatArray = self.standard**4 / np.sum(parts, axis=0)
        return np.where(np.isnan(degrees), np.inf, degrees)

    @cached_property
    def factor(self) -> FloatArray:
        """k, shape (t, n)."""
        return self.coverage.factors(self.degrees)

    @cached_property
    def expanded(self) -> FloatArray:
        """U = k·u_c (m, rad), shape (t, n)."""
        return self.factor * self.standard

    def repeated(self, times: FloatArray | float) -> FloatArray:
        """U (m, rad) when the whole experiment is done `times` times, everything set up anew, by the same estimator.

        k stays that of one experiment. Of any shape of `times` that goes with (t, n); as it is where `repetition` is
        not known.
        """
        if self.repetition is None:
            return np.broadcast_to(self.expanded, np.broadcast_shapes(np.shape(times), self.expanded.shape))
        once, several = self.repetition.variances(1.0), self.repetition.variances(times)
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.expanded * np.sqrt(np.where(once > 0.0, several / once, 1.0))

    @cached_property
    def covariance(self) -> FloatArray:
        """Of the attained poses together (m², m·rad, rad²), shape (t, n, t, n).

        Raises:
            ValueError: a contribution is known axis by axis alone.
        """
        total = np.zeros((*self.tolerance.shape, *self.tolerance.shape))
        for each in self.contributions:
            if each.covariance is None:
                message = f"of {each.name} only the axes by themselves are known"
                raise ValueError(message)
            total = total + each.covariance
        return total


def tolerances(problem: "DesignProblem") -> FloatArray:
    """Tolerances of the targets (m, rad), shape (t, n), NaN where an axis does not matter."""
    importance = problem.targets.importance
    with np.errstate(divide="ignore"):
        return np.where(importance > 0.0, 1.0 / np.sqrt(importance), np.nan)
