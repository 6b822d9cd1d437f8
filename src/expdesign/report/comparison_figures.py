"""Figures and tables of the page of `expdesign compare`."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from expdesign.assurance.comparison.correlation import RankCorrelation
from expdesign.assurance.comparison.judgement import Judgement
from expdesign.report import words
from expdesign.report.blocks import DataTable, Figure, PageSection, Shown, framed, number_of, table_of
from expdesign.report.figures import axis, bars, chart, colour, curve, points, whiskers
from expdesign.report.page import plot_text

Correlations = Sequence[list[RankCorrelation]]
_LOGARITHMIC: dict[str, Any] = {"type": "log", "dtick": "D2", "tickformat": "~g"}
"""A logarithmic axis with whole numbers at 1, 2 and 5 of every decade."""


def designs(judgement: Judgement) -> pd.DataFrame:
    """The designs, best accuracy first: `title` is what one is called, `together` with all others of its `plan`."""
    frame = judgement.frame().assign(plan=judgement.same_plan)
    names = zip(frame["design"], frame["origin"], strict=True)
    frame["title"] = [words.criterion(name) if origin == "optimised" else name for name, origin in names]
    frame["together"] = frame["plan"].map(_named(frame).groupby("plan")["title"].agg(", ".join))
    return frame.sort_values("attained", kind="stable")


def _named(frame: pd.DataFrame) -> pd.DataFrame:
    """All designs but the random ones."""
    return frame[frame["origin"] != "random"]


def named(judgement: Judgement) -> pd.DataFrame:
    """Designs that are shown by name: all but the random ones, best accuracy first."""
    return _named(designs(judgement))


def random_ones(judgement: Judgement) -> pd.DataFrame:
    """Random designs that identify the targets, best accuracy first."""
    frame = designs(judgement)
    return frame[(frame["origin"] == "random") & np.isfinite(frame["attained"])]


def all_configurations(
    names: Sequence[str], judgements: Sequence[Judgement], correlations: Correlations, together: bool
) -> PageSection:
    """The design of each criterion in every configuration, as a figure and a table."""
    shades = ("accent", "load", "recommended", "knee", "total", "noise")
    quantity = "attained" if together else "attained_ratio"
    traces = []
    for index, (name, judgement) in enumerate(zip(names, judgements, strict=True)):
        own = _named(designs(judgement).sort_index())
        errors = whiskers(own[f"{quantity}_standard_error"].to_numpy())
        labels, values = [plot_text(title) for title in own["title"]], own[quantity].to_numpy()
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
    criteria = list(dict.fromkeys(name for one in judgements for name in one.problem.criteria))
    columns: dict[str, list[float]] = {}
    for name, judgement, found in zip(names, judgements, correlations, strict=True):
        ratios = dict(zip(judgement.frame()["design"], judgement.attained_ratio.tolist(), strict=True))
        over = {one.criterion: one.coefficient for one in found if one.over == "random designs"}
        columns[f"{name}: error / best"] = [ratios.get(one, np.nan) for one in criteria]
        columns[f"{name}: rank correlation"] = [over.get(one, np.nan) for one in criteria]
    frame = pd.DataFrame({"criterion": criteria, **columns})
    cells = [[words.number(v) if k % 2 == 0 else signed(v) for v in one] for k, one in enumerate(columns.values())]
    rows = [list(row) for row in zip(map(words.criterion, criteria), *cells, strict=True)]
    caption = (
        "For every criterion: how many times the best design's error its own design leaves, and its rank correlation "
        "with the attained accuracy over random designs."
    )
    table = table_of("criteria", caption, ["Criterion", *columns], rows, frame)
    return PageSection("several", "All configurations", [figure, table])


def accuracy_figure(index: int, judgement: Judgement) -> Figure:
    """Attained error of every design that is shown, and of the random ones."""
    rows, drawn = named(judgement).drop_duplicates("plan"), random_ones(judgement)
    labels = [plot_text(text) for text in rows["together"]]
    errors = whiskers(rows["attained_standard_error"].to_numpy())
    traces = [bars("designs", labels, rows["attained"].to_numpy(), "accent", error_y=errors)]
    if len(drawn):
        values = drawn["attained"].to_numpy()
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
    frame, traces = designs(judgement).sort_index(), []
    for origin, shade in (("optimised", "accent"), ("random", "design"), ("given", "load")):
        own = frame[frame["origin"] == origin]
        if len(own):
            dots = points(origin, own["total"].to_numpy(), own["attained"].to_numpy(), shade, size=9)
            hover = "%{text}: predicted %{x:.4g}, attained %{y:.4g}<extra></extra>"
            traces.append({**dots, "text": [plot_text(title) for title in own["title"]], "hovertemplate": hover})
    ends = [float(frame["total"].min()), float(frame["total"].max())]
    traces.append(curve("attained = predicted", ends, ends, "muted", dash="dot"))
    return chart(
        f"prediction-{index}", "Attained against predicted", traces,
        "Every point is one design. On the line the criterion total has predicted the accuracy exactly.",
        "Scatter of the attained error against the prediction; the table's CSV holds the numbers.",
        x=axis("predicted (criterion total), tolerances", **_LOGARITHMIC),
        y=axis("attained, tolerances", **_LOGARITHMIC),
        filename="prediction", showlegend=True,
    )  # fmt: skip


def cross_table(index: int, judgement: Judgement) -> DataTable:
    """Every design that is shown, judged by every criterion."""
    drawn = random_ones(judgement)
    picked = drawn.iloc[[0, len(drawn) // 2, -1] if len(drawn) else []]
    picked = picked.assign(together=["best random", "median random", "worst random"][: len(picked)])
    listed = pd.concat([named(judgement).drop_duplicates("plan"), picked])

    def ratio(row: Any) -> str:
        error = row.attained_ratio_standard_error
        small = "<\u202f0.001" if error < 0.0005 else words.number(error, 1)
        return f"{words.number(row.attained_ratio)} ± {small}"

    shown: Shown = {
        "Design by": "together",
        "Attained (tolerances)": lambda row: (
            f"{words.number(row.attained)} ± {words.number(row.attained_standard_error, 1)}"
        ),
        "Attained / best": ratio,
        **{words.criterion(name): number_of(f"{name}_ratio") for name in judgement.values},
    }
    caption = (
        "Cross table. A row is a design, a column a criterion by which it is judged, as a ratio to the best of all "
        "designs by that criterion: 1 is the best, 2 is twice as bad. ± is one standard error. Criteria that lead to "
        "the same plan share a row."
    )
    table = framed(f"cross-{index}", caption, listed, shown)
    return table_of(table.id, caption, table.columns, table.rows, judgement.frame())


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
