"""What physics beyond the model still does at the targets when the readings are known: figure, table and sentences."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

from expdesign.assurance.model_error.meir import Meir, meir_of_problem
from expdesign.assurance.model_error.statement import (
    AccuracyStatement,
    HiddenPhysics,
    hidden_by_plan,
)
from expdesign.planning.front import Front, non_dominated
from expdesign.planning.problem import DesignProblem
from expdesign.report import words
from expdesign.report.blocks import Block, DataTable, Figure, PageSection, Sentences, framed, number_of
from expdesign.report.figures import axis, bars_across, chart, level, points

_CHEAP = 0.05
"""Part of the least total error that noticing may cost before it is called dear."""
_BARS = 30
"""Of the figure of what could stay hidden."""


def hidden_section(problem: DesignProblem, front: Front) -> PageSection:
    """The section about the recommended design; empty where the configuration asks for no MEIR."""
    meir, assessment = meir_of_problem(problem), problem.assessed(front.decisions[[front.recommended]])
    hidden = hidden_by_plan(problem, assessment, "the recommended plan")
    blocks: list[Block] = []
    if meir is not None and hidden is not None:
        physics, stated = hidden.physics, AccuracyStatement.of(assessment, hidden)
        texts = [(stated or hidden).sentence, *cheapest_sentences(front)]
        noticing = noticed_by(problem, front, meir, physics)
        blocks = [Sentences(texts), *hidden_blocks(physics, noticing)]
    return PageSection("hidden", "What the plan would not notice", blocks)


def noticed_by(
    problem: DesignProblem, front: Front, meir: Meir, physics: tuple[HiddenPhysics, ...]
) -> dict[tuple[str, str, str], str]:
    """For each effect the design of least total error that notices it before it uses up the tolerance, in words."""
    total = front.criteria["total"]
    squares = meir.hidden(problem.assessed(front.decisions)).squares
    found = {}
    for each in physics:
        name = each.physics, each.component, each.variant
        entries = [i for i, entry in enumerate(meir.physics) if entry.key == name]
        noticing = np.flatnonzero(squares[:, entries].max(axis=1) <= 1.0)
        text = "none on the front"
        if len(noticing):
            best = int(noticing[np.argmin(total[noticing])])
            text = f"design {best + 1}, +{_dearer(front, best)} %"
        found[name] = "this plan" if each.error <= 1.0 else text
    return found


def cheapest_sentences(front: Front) -> list[str]:
    """Which design of the front notices most at little cost in total error."""
    total, meir = front.criteria["total"], front.criteria["meir"]
    if not np.isfinite(meir[front.recommended]):
        return []
    affordable = np.flatnonzero(total <= (1.0 + _CHEAP) * total[front.recommended])
    best = int(affordable[np.nanargmin(meir[affordable])])
    if meir[best] >= meir[front.recommended] * (1.0 - 1e-6):
        percent = f"{100.0 * _CHEAP:.0f}\u00a0%"
        return [f"No design on the front hides less than that within {percent} of the least total error."]
    text = (
        f"Design {best + 1} hides {words.number(float(meir[best]))} tolerances instead of "
        f"{words.number(float(meir[front.recommended]))}, for {_dearer(front, best)}\u00a0% more total error"
    )
    if set(front.objectives) == {"total", "meir"}:
        return [f"{text}."]
    kept = len(non_dominated(np.stack([total, meir], axis=1)))
    are = "is" if kept == 1 else "are"
    return [f"{text}; by these two alone, {words.count(kept, 'design')} of the front {are} best."]


def _dearer(front: Front, design: int) -> str:
    """Total error of a design beyond that of the recommended one, in per cent."""
    total = front.criteria["total"]
    return words.number(100.0 * float(total[design] / total[front.recommended] - 1.0), 2)


def by_component(physics: tuple[HiddenPhysics, ...]) -> list[HiddenPhysics]:
    """The worst variant of every physics at every component, the largest error first."""
    worst: dict[tuple[str, str], HiddenPhysics] = {}
    for each in physics:
        worst.setdefault((each.physics, each.component), each)
    return list(worst.values())


def hidden_blocks(
    physics: tuple[HiddenPhysics, ...], noticing: dict[tuple[str, str, str], str] | None = None
) -> list[Block]:
    """The figure and the table; see `_table`."""
    return [_figure(physics), _table(physics, noticing)]


def _figure(physics: tuple[HiddenPhysics, ...]) -> Figure:
    """A bar per physics and component: the error that stays hidden."""
    shown = by_component(physics)[:_BARS]
    traces = []
    for limit, name, shade in (
        ("detection", "as far as the readings leave it open", "noise"),
        ("prior", "as large as machines are assumed to have it", "load"),
    ):
        some = [each for each in shown if (each.limited_by == "detection") == (limit == "detection")]
        growth = {"text": [_growth(each) for each in some], "textposition": "none"}
        hover = "%{y}<br>%{x:.3g} tolerances; %{text}<extra></extra>"
        traces.append(
            bars_across(name, [_label(each) for each in some], [each.error for each in some], shade, **growth,
                        hovertemplate=hover)
        )  # fmt: skip
    seen = [each for each in shown if each.noticed < np.inf]
    traces.append(
        points("noticed from here on", [each.error * each.noticed for each in seen], [_label(each) for each in seen],
               "ink", size=9, symbol="diamond-open",
               hovertemplate="%{y}<br>noticed from %{x:.3g} tolerances on<extra></extra>")
    )  # fmt: skip
    longest = max([1.0, *(each.error for each in shown)])
    order = {"categoryorder": "array", "categoryarray": [_label(each) for each in shown]}
    return chart(
        "hidden-bars", "What could stay hidden", [trace for trace in traces if len(trace["x"])],
        "How far off the targets each effect alone still puts the robot after compensation (standard deviation). "
        "Dashed: the tolerance is used up. An effect without a diamond in sight is noticed only when it is larger than "
        "shown.",
        "Bars of the hidden error per physics and component. The table has the same numbers.",
        x=axis("hidden error at the targets, in tolerances", range=[0.0, 1.1 * longest]),
        y={"autorange": "reversed", "automargin": True, **order}, levels=[level(1.0, "ink", dash="dash", upright=True)],
        height=min(1200, 170 + 26 * len(shown)), filename="hidden-physics", bargap=0.25, barmode="overlay",
        showlegend=True,
    )  # fmt: skip


def _label(each: HiddenPhysics) -> str:
    return each.phrase if each.component in each.phrase else f"{each.phrase} ({each.component})"


def _growth(each: HiddenPhysics) -> str:
    noticed = "never noticed" if not np.isfinite(each.noticed) else f"noticed at {words.number(each.noticed)} times it"
    return f"{noticed}, tolerance used up at {words.number(each.tolerable)} times it"


def _table(physics: tuple[HiddenPhysics, ...], noticing: dict[tuple[str, str, str], str] | None) -> DataTable:
    """Hidden error, the size at which an effect is noticed, and that at which it uses up the tolerance.

    Args:
        physics: what is hidden, the worst first.
        noticing: what `noticed_by` found, where there are plans to choose from.
    """
    columns = ["physics", "component", "variant", "error", "hidden", "noticed", "tolerance_used_up", "parameter"]
    data = []
    for each in physics:
        value = each.parameters[each.parameter]
        sizes = (each.error, value, each.noticed * value, each.tolerable * value)
        data.append([each.physics, each.component, each.variant, *sizes, each.parameter])
    frame = pd.DataFrame(data, columns=columns)
    phrases = [each.phrase for each in physics]
    shown: dict[str, str | Callable[[Any], str]] = {
        "Effect": lambda row: phrases[row.Index],
        "Component": lambda row: f"{row.component} ({row.variant})" if row.variant else row.component,
        "Parameter": lambda row: words.parameter(row.parameter, row.hidden).heading,
        "Hidden error": number_of("error"),
    }
    caption = (
        "Every effect considered, with the parameter that is largest against its prior size in the combination that "
        "adds most: the size that stays hidden (standard deviation), the size from which it is noticed with the "
        "required power, and the size at which the "
        "effect alone uses up the tolerance."
    )
    if noticing is not None:
        frame.insert(4, "noticed_by", [noticing[each.physics, each.component, each.variant] for each in physics])
        shown["Noticed in time by"] = "noticed_by"
        caption += (
            " Noticed in time: the design of the front with the least total error by which the effect shows before it "
            "uses up the tolerance, and what that adds to the total error."
        )
    shown |= {
        "Hidden size": lambda row: _size(row, row.hidden),
        "Noticed from": lambda row: _size(row, row.noticed),
        "Tolerance used up at": lambda row: _size(row, row.tolerance_used_up),
    }
    return framed("hidden-table", caption, frame, shown, tall=True)


def _size(row: Any, value: float) -> str:
    return words.number(words.parameter(row.parameter, row.hidden).factor * value) if np.isfinite(value) else "never"
