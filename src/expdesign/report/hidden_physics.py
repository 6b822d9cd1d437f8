"""What physics beyond the model could do at the targets without being noticed: figure, table and sentences of MEIR."""

import numpy as np
import pandas as pd

from expdesign.design.front import Front, non_dominated
from expdesign.design.problem import DesignProblem
from expdesign.files.csv_writer import csv_text
from expdesign.model_error.hidden_physics import HiddenPhysics
from expdesign.model_error.record import hidden_by_plan, meir_of_problem
from expdesign.model_error.recorded import HiddenByRecordings
from expdesign.model_error.statement import AccuracyStatement
from expdesign.model_error.words import phrase, sentence
from expdesign.report import words
from expdesign.report.blocks import Block, DataTable, Download, Figure, Section, Sentences

_MOST = 30
"""Bars of the figure; the table has all effects."""
_CHEAP = 0.05
"""Part of the least total error that noticing may cost before it is called dear."""


def hidden_section(problem: DesignProblem, front: Front) -> Section | None:
    """The section about the recommended design, or None where the configuration asks for no MEIR."""
    meir = meir_of_problem(problem)
    if meir is None:
        return None
    assessment = problem.assess(*problem.space.decode(front.decisions[[front.recommended]]))
    physics, freedom = hidden_by_plan(meir, assessment)
    if not physics:
        return None
    stated = AccuracyStatement.of(assessment, physics, freedom, "the recommended plan")
    texts = [sentence(physics[0], freedom, "the recommended plan") if stated is None else stated.sentence]
    cheap = cheapest_sentence(front)
    if cheap is not None:
        texts.append(cheap)
    blocks: list[Block] = [Sentences(texts), hidden_figure(physics), hidden_table(physics)]
    return Section("hidden", "What the plan would not notice", blocks)


def recordings_section(found: HiddenByRecordings, stated: AccuracyStatement | None = None) -> Section:
    """The section about recordings that the model explains, with the accuracy to expect where it is known."""
    text = sentence(found.physics[0], found.freedom, "these recordings") if stated is None else stated.sentence
    return Section("hidden", "What may still be hidden", [Sentences([text]), hidden_figure(found.physics),
                                                          hidden_table(found.physics)])  # fmt: skip


def cheapest_sentence(front: Front) -> str | None:
    """Which design of the front notices most at little cost in total error."""
    total, meir = front.criteria["total"], front.criteria["meir"]
    if not np.isfinite(meir[front.recommended]):
        return None
    affordable = np.flatnonzero(total <= (1.0 + _CHEAP) * total[front.recommended])
    best = int(affordable[np.nanargmin(meir[affordable])])
    if meir[best] >= meir[front.recommended] * (1.0 - 1e-6):
        return (
            f"No design on the front hides less than that within {100.0 * _CHEAP:.0f}\u00a0% of the least total error."
        )
    more = 100.0 * (total[best] / total[front.recommended] - 1.0)
    kept = len(non_dominated(np.stack([total, meir], axis=1)))
    return (
        f"Design {best + 1} hides {words.number(float(meir[best]))} tolerances instead of "
        f"{words.number(float(meir[front.recommended]))}, for {words.number(more, 2)}\u00a0% more total error; by "
        f"these two alone, {words.count(kept, 'design')} of the front {'is' if kept == 1 else 'are'} best."
    )


def by_component(physics: tuple[HiddenPhysics, ...]) -> list[HiddenPhysics]:
    """The worst variant of every physics at every component, the largest error first."""
    worst: dict[tuple[str, str], HiddenPhysics] = {}
    for each in physics:
        worst.setdefault((each.physics, each.component), each)
    return list(worst.values())


def hidden_figure(physics: tuple[HiddenPhysics, ...]) -> Figure:
    """A bar per physics and component: the error that stays hidden."""
    shown = by_component(physics)[:_MOST]
    labels = [f"{each.physics.replace('_', ' ')}, {each.component}" for each in shown]
    colours = ["var(--noise)" if each.limited_by == "detection" else "var(--load)" for each in shown]
    data = [
        {
            "type": "bar",
            "orientation": "h",
            "y": labels,
            "x": [each.error for each in shown],
            "text": [_growth(each) for each in shown],
            "textposition": "none",
            "marker": {"color": colours},
            "showlegend": False,
            "hovertemplate": "%{y}<br>%{x:.3g} tolerances; %{text}<extra></extra>",
        }
    ]
    layout = {
        "xaxis": {"title": {"text": "hidden error at the targets, in tolerances"}, "rangemode": "tozero"},
        "yaxis": {"autorange": "reversed", "automargin": True},
        "bargap": 0.25,
    }
    caption = (
        "How far off the targets each effect alone could be after compensation without showing in the residuals "
        "(1 = the tolerance). In the colour of noise: as large as goes unnoticed; in that of loads: as large as "
        "machines are assumed to have it."
    )
    description = "Bars of the hidden error per physics and component. The table has the same numbers."
    return Figure(
        "hidden-bars", "What could stay hidden", {"data": data, "layout": layout}, caption, description,
        height=min(1200, 150 + 26 * len(shown)), filename="hidden-physics",
    )  # fmt: skip


def _growth(each: HiddenPhysics) -> str:
    noticed = "never noticed" if not np.isfinite(each.noticed) else f"noticed at {words.number(each.noticed)} times it"
    return f"{noticed}, tolerance used up at {words.number(each.tolerable)} times it"


def hidden_table(physics: tuple[HiddenPhysics, ...]) -> DataTable:
    """Hidden error, the size at which an effect is noticed, and that at which it uses up the tolerance."""
    rows, data = [], []
    for each in physics:
        name, value = max(each.parameters.items(), key=lambda item: abs(item[1]))
        noticed, tolerable = each.noticed * value, each.tolerable * value
        texts = [words.number(each.error), name, words.number(value), words.number(noticed), words.number(tolerable)]
        variant = f" ({each.variant})" if each.variant else ""
        rows.append([phrase(each), f"{each.component}{variant}", *texts])
        data.append([each.physics, each.component, each.variant, each.error, name, value, noticed, tolerable])
    columns = ["physics", "component", "variant", "error", "parameter", "hidden", "noticed", "tolerance_used_up"]
    caption = (
        "Every effect considered, with the largest parameter of its worst combination: the size that is hidden, the "
        "size from which it is noticed with the required power, and the size at which it alone uses up the tolerance."
    )
    heads = ["Effect", "Component", "Hidden error", "Parameter", "Hidden size", "Noticed from", "Tolerance used up at"]
    download = Download("hidden.csv", csv_text(pd.DataFrame(data, columns=columns)))
    return DataTable("hidden-table", caption, heads, rows, download, tall=True)
