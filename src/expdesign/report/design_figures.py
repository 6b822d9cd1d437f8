"""Figures of the page of `expdesign run`; `design_report.js` fills in what depends on the chosen design."""

from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.criteria.criterion import Criterion, known_criteria
from expdesign.design.front import Front
from expdesign.model_error.meir import Meir
from expdesign.report import words
from expdesign.report.blocks import Figure
from expdesign.report.error_budget import ErrorBudget


def described(name: str) -> Criterion | type[Criterion]:
    """What a criterion is called, and in which unit it is."""
    return Meir if name == Meir.name else known_criteria()[name]


def criterion_title(name: str) -> str:
    """Title of a criterion's axis, with unit and direction."""
    criterion = described(name)
    unit = "" if criterion.unit == "1" else f", {criterion.unit}"
    return f"{criterion.title}{unit}{' (larger is better)' if criterion.maximise else ''}"


def shown_criteria(front: Front) -> tuple[str, ...]:
    """All criteria, those that a reader compares first in front."""
    first = dict.fromkeys((*front.objectives, "duir", "feir", "total"))
    return (*first, *(name for name in front.criteria if name not in first))


def hover_text(front: Front, design: int) -> str:
    """Every criterion of a design, for the box beside its point."""
    lines = [f"<b>Design {design + 1}</b>"]
    lines += [f"{words.criterion(name)} {words.number(front.criteria[name][design])}" for name in shown_criteria(front)]
    return "<br>".join(lines)


def front_figure(front: Front) -> Figure:
    """The front, with the recommended design, the knee and the chosen design marked."""

    def trace(name: str, marker: dict[str, Any], indices: list[int]) -> dict[str, Any]:
        return {
            "type": "scatter",
            "mode": "markers",
            "name": name,
            "marker": marker,
            "customdata": indices,
            "text": [hover_text(front, index) for index in indices],
            "hovertemplate": "%{text}<extra></extra>",
            **_coordinates(front, indices),
        }

    best, middle = front.recommended, front.knee
    plain = {"color": "var(--design)", "size": 9}
    star = {"color": "var(--recommended)", "size": 17, "symbol": "star"}
    square = {"color": "var(--knee)", "size": 12, "symbol": "diamond"}
    ring = {"color": "var(--ink)", "size": 21, "symbol": "circle-open", "line": {"width": 2.5}}
    data = [
        trace("designs", plain, list(range(len(front)))),
        trace(f"recommended: design {best + 1}", star, [best]),
        trace(f"knee: design {middle + 1}", square, [middle]),
        trace(f"chosen: design {best + 1}", ring, [best]),
    ]
    x, y = (criterion_title(name) for name in plotted(front))
    caption = (
        "Every point is one complete plan of measurements. Along the front one criterion improves only at the cost of "
        "another. Point at a design to read its criteria; click it, or choose it in the table of designs, to see its "
        "plan below."
    )
    description = (
        f"Scatter of {words.count(len(front), 'design')}: {x} against {y}. The table of designs holds the same numbers "
        "and lets you choose a design with the keyboard."
    )
    layout = {"xaxis": {"title": {"text": x}}, "yaxis": {"title": {"text": y}}, "showlegend": True}
    return Figure(
        "front", "Front of the designs", {"data": data, "layout": layout}, caption, description, filename="front"
    )


def plotted(front: Front) -> tuple[str, ...]:
    """The first two objectives; beside a single one, another criterion; of three with MEIR, it and the total error."""
    if len(front.objectives) > 2 and Meir.name in front.objectives:
        return "total", Meir.name
    first, second, *_ = dict.fromkeys((*front.objectives, "duir", "feir"))
    return first, second


def _coordinates(front: Front, indices: list[int]) -> dict[str, FloatArray]:
    x, y = (front.criteria[name][indices] for name in plotted(front))
    return {"x": x, "y": y}


def parallel_figure(front: Front) -> Figure:
    """Every design as a line over the objectives, each scaled from its worst value (0) to its best (1)."""
    names = tuple(dict.fromkeys((*front.objectives, "total")))
    columns, ticks = [], []
    for name in names:
        values = front.criteria[name]
        best, worst = (values.max(), values.min()) if described(name).maximise else (values.min(), values.max())
        columns.append((values - worst) / (best - worst) if best != worst else np.ones(len(values)))
        ticks.append(
            f"{words.criterion(name)}<br>best {words.number(float(best))}<br>worst {words.number(float(worst))}"
        )
    scaled = np.stack(columns, axis=-1)

    def line(design: int, look: dict[str, Any]) -> dict[str, Any]:
        return {
            "type": "scatter",
            "mode": "lines+markers",
            "x": list(range(len(names))),
            "y": scaled[design],
            "customdata": [design] * len(names),
            "text": [hover_text(front, design)] * len(names),
            "hovertemplate": "%{text}<extra></extra>",
            "showlegend": False,
            **look,
        }

    plain = {"line": {"color": "var(--design)", "width": 1}, "marker": {"size": 5}, "opacity": 0.45}
    best_look = {"line": {"color": "var(--recommended)", "width": 3}, "opacity": 1, "showlegend": True}
    chosen_look = {"line": {"color": "var(--ink)", "width": 3}, "opacity": 1, "showlegend": True}
    data = [line(design, plain) for design in range(len(front))]
    data.append(line(front.recommended, {**best_look, "name": f"recommended: design {front.recommended + 1}"}))
    data.append(line(front.recommended, {**chosen_look, "name": f"chosen: design {front.recommended + 1}"}))
    layout = {
        "xaxis": {"tickvals": list(range(len(names))), "ticktext": ticks, "range": [-0.3, len(names) - 0.7]},
        "yaxis": {"title": {"text": "worst → best"}, "tickvals": [0, 0.5, 1], "range": [-0.05, 1.05]},
    }
    caption = (
        "Every line is one design. Each objective is scaled from the worst value on the front (bottom) to the best "
        "(top): lines that cross between two objectives show that one is bought with the other. Click a line to choose "
        "its design."
    )
    description = f"Parallel coordinates of {words.count(len(front), 'design')} over {', '.join(names)}."
    return Figure(
        "parallel",
        "All objectives side by side",
        {"data": data, "layout": layout},
        caption,
        description,
        filename="objectives",
    )


def budget_figure(budget: ErrorBudget) -> Figure:
    """Noise, load error and total of every axis that matters, in tolerances."""
    rows = budget.rows_that_matter()
    labels = [f"target {target + 1}, {words.axis(budget.axes[axis])}" for target, axis in rows]
    names = (("measurement noise", "noise"), ("load errors", "load"), ("together", "total"))
    data = [
        {
            "type": "bar",
            "orientation": "h",
            "name": name,
            "y": labels,
            "x": [],
            "marker": {"color": f"var(--{colour})"},
            "textposition": "none",
            "hovertemplate": f"%{{y}}<br>{name}: %{{text}} (%{{x:.3g}} tolerances)<extra></extra>",
        }
        for name, colour in names
    ]
    layout = {
        "barmode": "group",
        "bargap": 0.25,
        "xaxis": {"title": {"text": "expected RMS error, in tolerances"}, "rangemode": "tozero"},
        "yaxis": {"autorange": "reversed"},
        "legend": {"traceorder": "normal"},
    }
    caption = (
        "What is left after calibration, as a share of the tolerance (1 = the tolerance). Noise of the measurements "
        "and errors of the loads in the experiment are independent, so they add in squares."
    )
    description = "Bars of the expected error per target and axis. The table of the error budget has the same numbers."
    height = min(1200, 150 + 46 * len(rows))
    return Figure(
        "budget",
        "Where the remaining error comes from",
        {"data": data, "layout": layout},
        caption,
        description,
        height=height,
        filename="error-budget",
    )
