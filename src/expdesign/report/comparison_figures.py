"""Figures and tables of the page of `expdesign compare`."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from expdesign.assurance.comparison.correlation import RankCorrelation
from expdesign.assurance.comparison.judgement import Judgement
from expdesign.report import words
from expdesign.report.blocks import DataTable, Figure, PageSection, Shown, framed, table_of
from expdesign.report.figures import axis, bars, chart, colour, curve, points, whiskers
from expdesign.report.page import plot_text

Correlations = Sequence[list[RankCorrelation]]


def shown(judgement: Judgement) -> list[int]:
    """Designs that are shown by name: all but the random ones, best accuracy first."""
    named = [i for i, contender in enumerate(judgement.contenders) if contender.origin != "random"]
    attained = judgement.attained
    return sorted(named, key=lambda i: (np.isnan(attained[i]), attained[i]))


def random_ones(judgement: Judgement) -> list[int]:
    """Random designs that identify the targets, best accuracy first."""
    drawn = [i for i, contender in enumerate(judgement.contenders) if contender.origin == "random"]
    return sorted((i for i in drawn if np.isfinite(judgement.attained[i])), key=lambda i: judgement.attained[i])


def title(name: str, origin: str) -> str:
    """What a design is called."""
    return words.criterion(name) if origin == "optimised" else name


def title_of(judgement: Judgement, index: int) -> str:
    """What a design is called, by its number."""
    return title(judgement.contenders[index].name, judgement.contenders[index].origin)


def all_configurations(
    names: Sequence[str], judgements: Sequence[Judgement], correlations: Correlations, together: bool
) -> PageSection:
    """The design of each criterion in every configuration, as a figure and a table."""
    shades = ("accent", "load", "recommended", "knee", "total", "noise")
    quantity = "attained" if together else "attained_ratio"
    traces = []
    for index, (name, judgement) in enumerate(zip(names, judgements, strict=True)):
        named = [i for i, contender in enumerate(judgement.contenders) if contender.origin != "random"]
        labels = [plot_text(title_of(judgement, i)) for i in named]
        errors = whiskers(getattr(judgement, f"{quantity}_standard_error")[named])
        values = getattr(judgement, quantity)[named]
        traces.append(bars(plot_text(name), labels, values, shades[index % len(shades)], error_y=errors))
    unit = "attained error, tolerances" if together else "attained error / own best"
    what = (
        "Targets, tolerances and noise are the same in all configurations, so that the errors can be compared."
        if together
        else "Targets, tolerances or noise differ: each configuration is shown relative to its own best design."
    )
    figure = chart(
        "per-criterion", "The design of each criterion in every configuration", traces,
        f"{what} Whiskers are standard errors.",
        f"Bars of the {unit} per criterion and configuration; the tables below hold the numbers.",
        y=axis(unit, rangemode="tozero"), filename="configurations", barmode="group", showlegend=True,
    )  # fmt: skip
    rows: list[list[str]] = []
    table: list[list[object]] = []
    for criterion in dict.fromkeys(name for one in judgements for name in one.problem.criteria):
        cells = []
        for judgement, found in zip(judgements, correlations, strict=True):
            if criterion not in judgement.problem.criteria:
                cells += [np.nan, np.nan]
                continue
            design = next(i for i, one in enumerate(judgement.contenders) if one.name == criterion)
            over = next((one for one in found if (one.criterion, one.over) == (criterion, "random designs")), None)
            cells += [float(judgement.attained_ratio[design]), np.nan if over is None else over.coefficient]
        table.append([criterion, *cells])
        texts = [words.number(v) if i % 2 == 0 else signed(v) for i, v in enumerate(cells)]
        rows.append([words.criterion(criterion), *texts])
    columns = [f"{name}: {head}" for name in names for head in ("error / best", "rank correlation")]
    caption = (
        "For every criterion: how many times the best design's error its own design leaves, and its rank correlation "
        "with the attained accuracy over random designs."
    )
    frame = pd.DataFrame(table, columns=["criterion", *columns])
    return PageSection(
        "several", "All configurations", [figure, table_of("criteria", caption, ["Criterion", *columns], rows, frame)]
    )


def together_title(judgement: Judgement, index: int) -> str:
    """What a design is called, with the others of the same plan."""
    first = judgement.same_plan
    alike = [i for i in range(len(first)) if first[i] == first[index] and judgement.contenders[i].origin != "random"]
    return ", ".join(title_of(judgement, i) for i in alike)


def different(judgement: Judgement) -> list[int]:
    """Designs that are shown, each plan once."""
    first = judgement.same_plan
    rows: list[int] = []
    for i in shown(judgement):
        if all(first[i] != first[other] for other in rows):
            rows.append(i)
    return rows


def accuracy_figure(index: int, judgement: Judgement) -> Figure:
    """Attained error of every design that is shown, and of the random ones."""
    rows = different(judgement)
    labels = [plot_text(together_title(judgement, i)) for i in rows]
    errors = whiskers(judgement.attained_standard_error[rows])
    traces = [bars("designs", labels, judgement.attained[rows], "accent", error_y=errors)]
    drawn = random_ones(judgement)
    if drawn:
        values = judgement.attained[drawn]
        traces.append({"type": "box", "name": "random", "y": values, "marker": {"color": colour("design")}})
    return chart(
        f"accuracy-{index}", "Accuracy attained with each design", traces,
        "RMS error at the targets after experiment, identification and compensation. The design of each criterion is "
        "the best by this criterion alone that searches and gradients find; criteria with the same plan share a bar. "
        "Whiskers are standard errors; the box is of random designs.",
        "Bars of the attained error per design, best first; the cross table holds the numbers.",
        y=axis("attained error, tolerances", rangemode="tozero"), filename="accuracy", showlegend=False,
    )  # fmt: skip


def prediction_figure(index: int, judgement: Judgement) -> Figure:
    """Attained error of every design against the criterion total."""
    predicted, attained = judgement.values["total"], judgement.attained
    traces = []
    for origin, shade in (("optimised", "accent"), ("random", "design"), ("given", "load")):
        rows = [i for i, contender in enumerate(judgement.contenders) if contender.origin == origin]
        texts = [plot_text(title(judgement.contenders[i].name, origin)) for i in rows]
        hover = "%{text}: predicted %{x:.4g}, attained %{y:.4g}<extra></extra>"
        if rows:
            dots = points(origin, predicted[rows], attained[rows], shade, size=9)
            traces.append({**dots, "text": texts, "hovertemplate": hover})
    ends = [float(np.nanmin(predicted)), float(np.nanmax(predicted))]
    traces.append(curve("attained = predicted", ends, ends, "muted", dash="dot"))
    return chart(
        f"prediction-{index}", "Attained against predicted", traces,
        "Every point is one design. On the line the criterion total has predicted the accuracy exactly.",
        "Scatter of the attained error against the prediction; the table's CSV holds the numbers.",
        x=axis("predicted (criterion total), tolerances", type="log"), y=axis("attained, tolerances", type="log"),
        filename="prediction", showlegend=True,
    )  # fmt: skip


def cross_table(index: int, judgement: Judgement) -> DataTable:
    """Every design that is shown, judged by every criterion."""
    criteria = list(judgement.values)
    ratios = {criterion: judgement.ratio(criterion) for criterion in criteria}
    rows = []
    drawn = random_ones(judgement)
    picked = [(drawn[0], "best random"), (drawn[len(drawn) // 2], "median random"), (drawn[-1], "worst random")]
    for i, label in [(i, "") for i in different(judgement)] + (picked if drawn else []):
        error = float(judgement.attained_ratio_standard_error[i])
        small = "<\u202f0.001" if error < 0.0005 else words.number(error, 1)
        rows.append(
            [
                label or together_title(judgement, i),
                f"{words.number(float(judgement.attained[i]))} ± "
                f"{words.number(float(judgement.attained_standard_error[i]), 1)}",
                f"{words.number(float(judgement.attained_ratio[i]))} ± {small}",
                *(words.number(float(ratios[criterion][i])) for criterion in criteria),
            ]
        )
    caption = (
        "Cross table. A row is a design, a column a criterion by which it is judged, as a ratio to the best of all "
        "designs by that criterion: 1 is the best, 2 is twice as bad. ± is one standard error. Criteria that lead to "
        "the same plan share a row."
    )
    columns = ["Design by", "Attained (tolerances)", "Attained / best", *(words.criterion(one) for one in criteria)]
    return table_of(f"cross-{index}", caption, columns, rows, judgement.frame())


def correlation_figure(index: int, found: list[RankCorrelation]) -> Figure:
    """Rank correlation of every criterion with the attained accuracy."""
    traces = []
    for over, shade in (("all designs", "accent"), ("random designs", "design")):
        ones = [one for one in found if one.over == over]
        if ones:
            value, low, high = np.array([(one.coefficient, one.low, one.high) for one in ones]).T
            names = [words.criterion(one.criterion) for one in ones]
            errors = whiskers(high - value, value - low)
            traces.append(bars(f"{over} ({ones[0].designs})", names, value, shade, error_y=errors))
    return chart(
        f"correlation-{index}", "Rank correlation with the attained accuracy", traces,
        "1: the criterion puts the designs in the order of the accuracy that they attain; 0: it says nothing about "
        "it; below 0: it prefers the less accurate. Whiskers are 95 % intervals.",
        "Bars of the rank correlation per criterion; the table below holds the numbers.",
        y=axis("rank correlation with accuracy", range=[-1.05, 1.05]), filename="correlation", barmode="group",
        showlegend=True,
    )  # fmt: skip


def correlation_table(index: int, found: list[RankCorrelation]) -> DataTable:
    """The same as a table."""
    shown: Shown = {
        "Criterion": lambda row: words.criterion(row.criterion),
        "Over": "over",
        "Designs": "designs",
        "Rank correlation": lambda row: signed(row.coefficient),
        "95 % from": lambda row: signed(row.low),
        "to": lambda row: signed(row.high),
    }
    caption = "Spearman's rank correlation of each criterion with the attained accuracy."
    return framed(f"correlations-{index}", caption, pd.DataFrame([vars(one) for one in found]), shown, tall=True)


def signed(value: float) -> str:
    """A rank correlation as it is shown."""
    return words.UNDETERMINED if np.isnan(value) else words.fixed(value, 2)
