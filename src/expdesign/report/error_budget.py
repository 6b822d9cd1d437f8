"""How the error to expect at each target is made up: measurement noise, and each source of load error.

Standard deviations of the attained pose after compensation: noise √U_ii (theory.md 4.2), load errors √(Z·Σ_F·Zᵀ)_ii
(5.3), of which each source contributes its own columns of the root; independent parts add in squares.

The table of it with tolerances, pass or fail.
"""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.acceptance.budget import UncertaintyBudget
from expdesign.assurance.acceptance.decision import Basis, Decision
from expdesign.report import words
from expdesign.report.acceptance_texts import DECISION_RULE
from expdesign.report.blocks import KeyFigure

EXPLAINED = (
    f"Every axis in the table by itself: its expanded uncertainty U = k u is compared with its tolerance "
    f"({DECISION_RULE}). "
    "The expected error (total) of the criteria is another figure: the root of the sum over all axes of "
    "(u / tolerance)², without k, so that it can be above 1 although every axis passes, and below 1 although one fails."
)
_TONES = {"pass": "good", "expected to pass": "good", "not expected to pass": "bad"}


def acceptance_figure(decision: Decision) -> KeyFigure:
    """The verdict, for the first section of a page."""
    plan = decision.basis is Basis.PLAN
    label, note = ("Acceptance, axis by axis", "each axis is in the uncertainty budget") if plan else ("Acceptance", "")
    return KeyFigure(label, decision.verdict, "", note, _TONES.get(decision.verdict, ""))


def headings(decision: Decision) -> list[str]:
    """Headings of the table of uncertainty budget and acceptance."""
    parts = [f"u: {words.source(one.name)}" for one in decision.budget.contributions]
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


def parts(budget: UncertaintyBudget) -> FloatArray:
    """Standard deviations (m, rad) of noise, all load errors, both and each source at every axis, (t, n, 3 + s)."""
    noise, *sources = (one.deviation for one in budget.contributions)
    load = np.sqrt(sum((source**2 for source in sources), start=np.zeros_like(noise)))
    return np.stack([noise, load, budget.standard, *sources], axis=-1)
