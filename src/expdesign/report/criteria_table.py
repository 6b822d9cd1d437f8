"""Further criteria of one design beside the best of the front: the observability indices O1 to O5 among them."""

import numpy as np

from expdesign.planning.front import Front
from expdesign.report import words
from expdesign.report.blocks import DataTable
from expdesign.report.design_figures import described

CAPTION = (
    "Further criteria of design {design}. O1 to O5 are observability indices: how well all stiffnesses are determined, "
    "wherever the targets are. Beside them the best value on this front, and how near the design comes to it."
)
_FIRST = ("duir", "feir", "total")
"""Criteria that stand in the table of designs."""
_COLUMNS = ("Criterion", "Unit", "Better", "Design", "Best on the front", "Best / design")


def shown(front: Front) -> list[str]:
    """Criteria beside the objectives that tell designs apart: one that is 0 for all of them does not."""
    return [name for name, values in front.criteria.items() if name not in _FIRST and np.any(values != 0.0)]


def cells(front: Front, design: int) -> list[list[str]]:
    """Rows of the table of one design."""
    rows = []
    for name in shown(front):
        criterion, values = described(name), front.criteria[name]
        value = float(values[design])
        best = float(values.max() if criterion.maximise else values.min())
        smaller, larger = sorted((value, best))
        near = f"{words.number(100.0 * smaller / larger)} %" if larger > 0.0 else "–"
        better = "larger" if criterion.maximise else "smaller"
        unit = "–" if criterion.unit == "1" else criterion.unit
        rows.append([criterion.title, unit, better, words.number(value, 4), words.number(best, 4), near])
    return rows


def criteria_table(front: Front, design: int) -> DataTable:
    """The table as it stands at first."""
    return DataTable("criteria-table", CAPTION.replace("{design}", str(design + 1)), _COLUMNS, cells(front, design))
