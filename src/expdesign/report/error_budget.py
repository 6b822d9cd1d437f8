"""How the error to expect at each target is made up: measurement noise, and each source of load error.

Standard deviations of the attained pose after compensation: noise √U_ii (theory.md 4.2), load errors √(Z·Σ_F·Zᵀ)_ii
(5.3), of which each source contributes its own columns of the root; independent parts add in squares.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.acceptance.budget import source_deviations, tolerances
from expdesign.arrays import FloatArray
from expdesign.criteria.assessment import Assessment
from expdesign.design.problem import DesignProblem
from expdesign.report import words


@dataclass(frozen=True)
class ErrorBudget:
    """Standard deviations (m, rad) of the attained pose of b designs at t targets along n axes, NaN where unknown.

    Attributes:
        noise: from measurement noise, shape (b, t, n).
        load: from all load errors, shape (b, t, n).
        sources: from each source of load error, shape (b, t, n, s).
        source_names: what the sources are called.
        axes: deflection columns along the axes.
        tolerance: shape (t, n), NaN where an axis does not matter.
    """

    noise: FloatArray
    load: FloatArray
    sources: FloatArray
    source_names: tuple[str, ...]
    axes: tuple[str, ...]
    tolerance: FloatArray

    @property
    def total(self) -> FloatArray:
        """RMS error to expect, shape (b, t, n)."""
        total: FloatArray = np.hypot(self.noise, self.load)
        return total

    def rows(self) -> list[tuple[int, int]]:
        """Target and axis of each row of a table of the budget."""
        return [(target, axis) for target in range(len(self.tolerance)) for axis in range(len(self.axes))]

    def rows_that_matter(self) -> list[tuple[int, int]]:
        """The rows whose axis has a tolerance."""
        return [(target, axis) for target, axis in self.rows() if np.isfinite(self.tolerance[target, axis])]

    def in_tolerances(self, sigma: FloatArray) -> FloatArray:
        """RMS over the axes that matter of sigma (b, t, n) in units of the tolerance, shape (b, t).

        This is what DUIR and FEIR are made of: √(Σ_i σ_i²/tol_i²) of one target.
        """
        matters = np.isfinite(self.tolerance)
        return np.sqrt(np.where(matters, (sigma / self.tolerance) ** 2, 0.0).sum(axis=-1))


def error_budget(problem: DesignProblem, assessment: Assessment) -> ErrorBudget:
    """The error budget of the designs of an assessment."""
    noise = np.sqrt(assessment.noise_variance)
    return ErrorBudget(
        noise=noise,
        load=np.sqrt(assessment.force_variance),
        sources=source_deviations(problem, assessment),
        source_names=tuple(words.SOURCES.get(one.source, one.source) for one in problem.loaded.sources),
        axes=problem.loaded.robot.coordinates.deflection,
        tolerance=tolerances(problem),
    )


def headings(budget: ErrorBudget) -> list[str]:
    """Headings of the table of a budget."""
    return [
        "Target, axis",
        "Unit",
        "Noise σ",
        "Load error σ",
        "Total σ",
        "Tolerance",
        "Total, in tolerances",
        "Noise, share of σ²",
        *(f"Load error: {name} σ" for name in budget.source_names),
    ]


def cells(budget: ErrorBudget, design: int) -> list[list[str]]:
    """Rows of the table of one design's budget, as they are shown."""
    rows = []
    for target, axis in budget.rows():
        noise, load = budget.noise[design, target, axis], budget.load[design, target, axis]
        total, tolerance = budget.total[design, target, axis], budget.tolerance[target, axis]
        share = noise**2 / total**2 if total > 0.0 else np.nan
        matters = bool(np.isfinite(tolerance))
        rows.append(
            [
                f"target {target + 1}, {words.axis(budget.axes[axis])}",
                words.micro_unit(budget.axes[axis]),
                *(words.number(1e6 * sigma, scale=1e6 * total) for sigma in (noise, load, total)),
                words.given(1e6 * tolerance) if matters else "–",
                words.number(total / tolerance) if matters else "–",
                f"{words.number(100.0 * share, 2)} %" if np.isfinite(share) else "–",
                *(words.number(1e6 * sigma, scale=1e6 * total) for sigma in budget.sources[design, target, axis]),
            ]
        )
    return rows


def sentences(budget: ErrorBudget, design: int) -> list[str]:
    """The accuracy to expect at each target in words."""
    noise, load = budget.in_tolerances(budget.noise)[design], budget.in_tolerances(budget.load)[design]
    texts = []
    for target, limits in enumerate(budget.tolerance):
        axes = [int(axis) for axis in np.flatnonzero(np.isfinite(limits))]
        totals = budget.total[design, target]
        errors = [f"{_micro(budget, axis, totals[axis])} on {words.axis(budget.axes[axis])}" for axis in axes]
        worst = max(axes, key=lambda axis: totals[axis] / limits[axis])
        share = words.number(100.0 * totals[worst] / limits[worst])
        tolerance = f"{words.given(1e6 * limits[worst])}\u00a0{words.micro_unit(budget.axes[worst])}"
        if len(axes) == 1:
            texts.append(
                f"After calibration with this plan, the error to expect at target {target + 1} is {errors[0]}, RMS: "
                f"{share}\u00a0% of the tolerance of {tolerance}. It consists of "
                f"{_micro(budget, worst, budget.noise[design, target, worst])} from measurement noise and "
                f"{_micro(budget, worst, budget.load[design, target, worst])} from load errors, which add in squares."
            )
            continue
        texts.append(
            f"After calibration with this plan, the RMS error to expect at target {target + 1} is "
            f"{words.listed(errors)}. The most demanding axis is {words.axis(budget.axes[worst])}, with "
            f"{share}\u00a0% of its tolerance of {tolerance}. All axes together make "
            f"{words.number(np.hypot(noise[target], load[target]))} tolerances: {words.number(noise[target])} from "
            f"measurement noise and {words.number(load[target])} from load errors, which add in squares."
        )
    return texts


def worst_sentence(budget: ErrorBudget, design: int) -> str:
    """The most demanding axis of all targets in words."""
    ratio = budget.total[design] / budget.tolerance
    target, axis = (int(i) for i in np.unravel_index(int(np.nanargmax(ratio)), ratio.shape))
    tolerance = f"{words.given(1e6 * budget.tolerance[target, axis])}\u00a0{words.micro_unit(budget.axes[axis])}"
    return (
        f"After calibration with this plan, the most demanding axis is {words.axis(budget.axes[axis])} at target "
        f"{target + 1}: {_micro(budget, axis, budget.total[design, target, axis])} RMS are to be expected, "
        f"{words.number(100.0 * ratio[target, axis])}\u00a0% of the tolerance of {tolerance}."
    )


def _micro(budget: ErrorBudget, axis: int, sigma: float) -> str:
    return f"{words.number(1e6 * sigma)}\u00a0{words.micro_unit(budget.axes[axis])}"
