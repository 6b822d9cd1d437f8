"""The section of a report that says what is accepted: uncertainty budgets, tolerances, pass or fail."""

import numpy as np
import pandas as pd

from expdesign.acceptance.decision import DECISION_RULE, Decision, acceptance_record, sentences
from expdesign.files.csv_writer import csv_text
from expdesign.report import words
from expdesign.report.blocks import DataTable, Download, Paragraph, Section, Sentences


def acceptance_section(decision: Decision, of: str) -> Section:
    """The section for the plan or the identification that `of` names."""
    budget = decision.budget
    explained = (
        f"Every axis by itself: its expanded uncertainty U = k u is compared with its tolerance ({DECISION_RULE}). "
        "The expected error (total) of the criteria is another figure: the root of the sum over all axes of "
        "(u / tolerance)², without k, so that it can be above 1 although every axis passes, and below 1 although one "
        "fails."
    )
    columns = ["Target, axis", "Unit", *(f"u: {_named(one.name)}" for one in budget.contributions)]
    columns += ["u, combined", "k", "U", "Tolerance", "U / tolerance", "Result", "Repetitions needed"]
    rows = [_row(decision, int(t), int(n)) for t, n in np.argwhere(budget.matters)]
    frame = pd.json_normalize(
        [
            {"target": number} | axis
            for number, target in enumerate(acceptance_record(decision)["targets"], start=1)
            for axis in target["axes"]
        ]
    )
    csv = Download("acceptance.csv", csv_text(frame))
    caption = f"Uncertainty budget and acceptance of {of}; u are standard uncertainties (JCGM 100:2008)."
    return Section(
        "acceptance",
        "Acceptance",
        (
            Sentences(sentences(decision)),
            DataTable("acceptance-table", caption, columns, rows, csv),
            Paragraph(explained),
        ),
    )


def _row(decision: Decision, target: int, axis: int) -> list[str]:
    budget = decision.budget
    name, place = budget.axes[axis], (target, axis)
    repetitions, combined = decision.repetitions[place], 1e6 * float(budget.standard[place])
    return [
        f"target {target + 1}, {words.axis(name)}",
        words.micro_unit(name),
        *(words.number(1e6 * float(one.deviation[place]), scale=combined) for one in budget.contributions),
        words.number(combined),
        words.number(float(budget.factor[place])),
        words.number(1e6 * float(budget.expanded[place])),
        words.number(1e6 * float(budget.tolerance[place])),
        words.number(float(budget.expanded[place] / budget.tolerance[place])),
        "passes" if decision.passed[place] else "fails",
        str(int(repetitions)) if np.isfinite(repetitions) else "no number",
    ]


def _named(name: str) -> str:
    return words.SOURCES.get(name, name)
