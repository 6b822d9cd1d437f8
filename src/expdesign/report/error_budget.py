"""How the error to expect at each target is made up: measurement noise, and each source of load error.

Standard deviations of the attained pose after compensation: noise √U_ii (theory.md 4.2), load errors √(Z·Σ_F·Zᵀ)_ii
(5.3), of which each source contributes its own columns of the root; independent parts add in squares.

The section of a report that says what is accepted: uncertainty budgets, tolerances, pass or fail.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.assurance.acceptance.budget import UncertaintyBudget
from expdesign.assurance.acceptance.decision import Basis, Decision
from expdesign.assurance.model_error.statement import AccuracyStatement, WhatIsHidden
from expdesign.report import words
from expdesign.report.acceptance_texts import DECISION_RULE, acceptance_record, sentences
from expdesign.report.blocks import KeyFigure, PageSection, Paragraph, table_of
from expdesign.report.hidden_physics import hidden_blocks
from expdesign.report.said import Said

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


_TONES = {"pass": "good", "expected to pass": "good", "not expected to pass": "bad"}


def acceptance_figure(decision: Decision) -> KeyFigure:
    """The verdict, for the first section of a page."""
    plan = decision.basis is Basis.PLAN
    label, note = ("Acceptance, axis by axis", "each axis is in the uncertainty budget") if plan else ("Acceptance", "")
    return KeyFigure(label, decision.verdict, "", note, _TONES.get(decision.verdict, ""))


@dataclass(frozen=True)
class StatedAtTargets:
    """What is said of the targets of a configuration.

    Attributes:
        configuration: its path.
        acceptance: whether the robot is accepted.
        hidden: what the recordings may hide; None where that is not asked, or the model does not explain them.
        accuracy: the same beside noise and load errors.
    """

    configuration: str
    acceptance: Decision
    hidden: WhatIsHidden | None = None
    accuracy: AccuracyStatement | None = None

    @property
    def said(self) -> Said:
        """The decision, and what may still be hidden: a line for each sentence."""
        record: dict[str, Any] = {"acceptance": acceptance_record(self.acceptance)}
        if self.hidden is not None:
            record["hidden"] = self.hidden.record
            record["accuracy"] = None if self.accuracy is None else self.accuracy.record
        stated = self.accuracy or self.hidden
        hidden = [] if stated is None else [stated.sentence]
        return Said("", [*sentences(self.acceptance), *hidden], document=lambda: record)

    @property
    def figure(self) -> KeyFigure:
        """The verdict, for the first section of a page."""
        return acceptance_figure(self.acceptance)

    def sections(self, of: str) -> list[PageSection]:
        """The sections of a page about the model that `of` names."""
        decision = self.acceptance
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
        hidden = [] if self.hidden is None else hidden_blocks(self.hidden.physics)
        return [
            PageSection("acceptance", "Acceptance", [table, explained]),
            PageSection("hidden", "What may still be hidden", hidden),
        ]


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
