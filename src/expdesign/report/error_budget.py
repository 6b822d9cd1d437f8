"""How the error to expect at each target is made up: measurement noise, and each source of load error.

Standard deviations of the attained pose after compensation: noise √U_ii (theory.md 4.2), load errors √(Z·Σ_F·Zᵀ)_ii
(5.3), of which each source contributes its own columns of the root; independent parts add in squares.

The section of a report that says what is accepted: uncertainty budgets, tolerances, pass or fail.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.assurance.acceptance.budget import NOISE, Contribution, UncertaintyBudget, tolerances
from expdesign.assurance.acceptance.decision import Decision
from expdesign.assurance.acceptance.planned import expected_decision
from expdesign.assurance.acceptance.said import DECISION_RULE, acceptance_record, sentences
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.problem import DesignProblem
from expdesign.report import words
from expdesign.report.blocks import PageSection, Paragraph, Sentences, table_of

EXPLAINED = (
    f"Every axis in the table by itself: its expanded uncertainty U = k u is compared with its tolerance "
    f"({DECISION_RULE}). "
    "The expected error (total) of the criteria is another figure: the root of the sum over all axes of "
    "(u / tolerance)², without k, so that it can be above 1 although every axis passes, and below 1 although one fails."
)
_UNDECIDED = (
    "The expanded uncertainties are those of the refuted model, multiplied by the Birge ratio of its residuals. They "
    "do not bound what the missing physics does at the targets."
)


def acceptance_section(decision: Decision, of: str) -> PageSection:
    """The section for the identification that `of` names."""
    frame = pd.json_normalize(
        [
            {"target": number} | axis
            for number, target in enumerate(acceptance_record(decision)["targets"], start=1)
            for axis in target["axes"]
        ]
    )
    caption = f"Uncertainty budget and acceptance of {of}; u are standard uncertainties (JCGM 100:2008)."
    table = table_of("acceptance-table", caption, headings(decision), acceptance_rows(decision), frame)
    explained = Paragraph(EXPLAINED if decision.decided else _UNDECIDED)
    return PageSection("acceptance", "Acceptance", (Sentences(sentences(decision)), table, explained))


def headings(decision: Decision) -> list[str]:
    """Headings of the table of uncertainty budget and acceptance."""
    parts = [f"u: {words.SOURCES.get(one.name, one.name)}" for one in decision.budget.contributions]
    return ["Target, axis", "Unit", *parts, "u, combined", "k", "U", "Tolerance", "U / tolerance", "Result",
            "Repetitions needed"]  # fmt: skip


def acceptance_rows(decision: Decision) -> list[list[str]]:
    """Its rows: every axis with a tolerance."""
    repetitions, expanded = decision.repetitions, decision.budget.expanded
    return [
        _row(decision, int(target), int(axis), float(expanded[target, axis]), float(repetitions[target, axis]))
        for target, axis in np.argwhere(decision.budget.matters)
    ]


def _row(decision: Decision, target: int, axis: int, expanded: float, repetitions: float) -> list[str]:
    budget = decision.budget
    name, place = budget.axes[axis], (target, axis)
    combined = 1e6 * float(budget.standard[place])
    return [
        f"target {target + 1}, {words.axis(name)}",
        words.micro_unit(name),
        *(words.number(1e6 * float(one.deviation[place]), scale=combined) for one in budget.contributions),
        words.number(combined),
        words.number(float(budget.factor[place])),
        words.number(1e6 * expanded),
        words.number(1e6 * float(budget.tolerance[place])),
        words.number(expanded / float(budget.tolerance[place])),
        decision.axis_verdict(target, axis),
        str(int(repetitions)) if np.isfinite(repetitions) else "no number",
    ]


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
        sources=np.sqrt(assessment.source_variances),
        source_names=tuple(words.SOURCES.get(one.source, one.source) for one in problem.loaded.sources),
        axes=problem.loaded.robot.coordinates.deflection,
        tolerance=tolerances(problem),
    )


def decision(problem: DesignProblem, budget: ErrorBudget, design: int) -> Decision:
    """What is accepted of one design: its uncertainty budget against the tolerances."""
    sources = (
        Contribution(source.source, budget.sources[design, ..., index], not source.shared)
        for index, source in enumerate(problem.loaded.sources)
    )
    parts = (Contribution(NOISE, budget.noise[design], True), *sources)
    whole = UncertaintyBudget(parts, budget.tolerance, budget.axes, problem.coverage, problem.space.measurements)
    return expected_decision(problem, whole)


def worst_sentence(budget: ErrorBudget, design: int) -> str:
    """The most demanding axis of all targets in words."""
    ratio = budget.total[design] / budget.tolerance
    target, axis = (int(i) for i in np.unravel_index(int(np.nanargmax(ratio)), ratio.shape))
    name = budget.axes[axis]
    sigma = f"{words.number(1e6 * budget.total[design, target, axis])}\u00a0{words.micro_unit(name)}"
    tolerance = f"{words.given(1e6 * budget.tolerance[target, axis])}\u00a0{words.micro_unit(name)}"
    return (
        f"After calibration with this plan, the most demanding axis is {words.axis(name)} at target "
        f"{target + 1}: {sigma} RMS are to be expected, "
        f"{words.number(100.0 * ratio[target, axis])}\u00a0% of the tolerance of {tolerance}."
    )
