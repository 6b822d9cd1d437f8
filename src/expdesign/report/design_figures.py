"""Figures of the page of `expdesign run`; `design_report.js` fills in what depends on the chosen design."""

import numpy as np

from expdesign.assurance.acceptance.budget import UncertaintyBudget
from expdesign.assurance.model_error.meir import Meir
from expdesign.planning.criteria.criterion import Criterion, known_criteria
from expdesign.planning.front import Front
from expdesign.report import words
from expdesign.report.blocks import Figure
from expdesign.report.figures import axis, bars_across, chart, points


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
    best, middle = front.recommended + 1, front.knee + 1
    across, up = (front.criteria[name] for name in plotted(front))
    numbers, texts = list(range(len(front))), [hover_text(front, design) for design in range(len(front))]
    hover = "%{text}<extra></extra>"
    traces = [points("designs", across, up, "design", size=9, customdata=numbers, text=texts, hovertemplate=hover)]
    for name, shade, size, symbol in (
        (f"recommended: design {best}", "recommended", 17, "star"),
        (f"knee: design {middle}", "knee", 12, "diamond"),
        (f"chosen: design {best}", "ink", 21, "circle-open"),
    ):  # the script places them
        traces.append(points(name, [], [], shade, size=size, symbol=symbol, hovertemplate=hover))
    traces[-1]["marker"]["line"] = {"width": 2.5}
    x, y = (criterion_title(name) for name in plotted(front))
    return chart(
        "front", "Front of the designs", traces,
        "Every point is one complete plan of measurements. Along the front one criterion improves only at the cost of "
        "another. Point at a design to read its criteria; click it, or choose it in the table of designs, to see its "
        "plan above.",
        f"Scatter of {words.count(len(front), 'design')}: {x} against {y}. The table of designs holds the same numbers "
        "and lets you choose a design with the keyboard.",
        x=x, y=y, showlegend=True,
    )  # fmt: skip


def plotted(front: Front) -> tuple[str, ...]:
    """The first two objectives; beside a single one, another criterion; of three with MEIR, it and the total error."""
    if len(front.objectives) > 2 and Meir.name in front.objectives:
        return "total", Meir.name
    first, second, *_ = dict.fromkeys((*front.objectives, "duir", "feir"))
    return first, second


def budget_figure(budget: UncertaintyBudget) -> Figure:
    """Noise, load error and total of every axis that matters, in tolerances; the script fills in the bars."""
    rows = np.argwhere(budget.matters)
    labels = [f"target {target + 1}, {words.axis(budget.axes[column])}" for target, column in rows]
    traces = [
        bars_across(name, labels, [], shade, textposition="none",
                    hovertemplate=f"%{{y}}<br>{name}: %{{text}} (%{{x:.3g}} tolerances)<extra></extra>")
        for name, shade in (("measurement noise", "noise"), ("load errors", "load"), ("together", "total"))
    ]  # fmt: skip
    return chart(
        "budget", "Where the error comes from", traces,
        "What is left after calibration, as a share of the tolerance (1 = the tolerance). Noise of the measurements "
        "and errors of the loads in the experiment are independent, so they add in squares.",
        "Bars of the expected error per target and axis. The table of the uncertainty budget has the same numbers.",
        x=axis("expected RMS error, in tolerances", rangemode="tozero"), y={"autorange": "reversed"},
        height=min(1200, 150 + 46 * len(rows)), filename="error-budget", barmode="group", bargap=0.25,
        legend={"traceorder": "normal"},
    )  # fmt: skip
