"""The page of `expdesign compare`: which criterion's design is accurate, and how well each criterion foretells it."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from expdesign.comparison.correlation import RankCorrelation
from expdesign.comparison.judgement import AGREEMENT, Judgement
from expdesign.design.optimality.refinement import LowerBound
from expdesign.files.csv_writer import csv_text
from expdesign.report import words
from expdesign.report.blocks import (
    Block,
    DataTable,
    Definitions,
    Download,
    Figure,
    KeyFigure,
    KeyFigures,
    Paragraph,
    Section,
    Sentences,
    SideBySide,
    Subheading,
)
from expdesign.report.page import Page, plot_text

Correlations = Sequence[list[RankCorrelation]]


def comparison_report(
    names: Sequence[str],
    judgements: Sequence[Judgement],
    correlations: Correlations,
    bounds: Sequence[LowerBound],
    together: bool,
    how: Mapping[str, str],
) -> Page:
    """The report of a comparison.

    Args:
        names: of the configurations.
        judgements: one per configuration.
        correlations: of each configuration.
        bounds: on the criterion `total` of every plan.
        together: whether accuracies of different configurations mean the same.
        how: settings and their values, for the last section.
    """
    sections = [_summary(names, judgements, correlations, bounds)]
    if len(names) > 1:
        sections.append(_several(names, judgements, correlations, together))
    for index, (name, judgement, found) in enumerate(zip(names, judgements, correlations, strict=True)):
        sections.append(_configuration(index, name, judgement, found))
    sections += [Section("words", "What the words mean", [Definitions(_WORDS)]), _settings(judgements, how)]
    robots = ", ".join(dict.fromkeys(judgement.problem.loaded.robot.name for judgement in judgements))
    designs = words.count(sum(len(judgement.contenders) for judgement in judgements), "design")
    return Page("Comparison of criteria", f"{robots}; {designs} of {', '.join(names)}", sections)


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


def agreement(name: str, judgement: Judgement) -> list[str]:
    """Which criteria lead to the very same plan, and which to plans of the same accuracy."""
    first, texts = judgement.same_plan, []
    optimised = [i for i, one in enumerate(judgement.contenders) if one.origin == "optimised"]
    alike = [[i for i in optimised if first[i] == leader] for leader in dict.fromkeys(int(first[i]) for i in optimised)]
    named = [_listed([_title(judgement, i) for i in group]) for group in alike if len(group) > 1]
    if named:
        count = words.count(len(alike), "different plan")
        texts.append(
            f"{name}: the {len(optimised)} criteria lead to {count}. The same plan to the last measurement: "
            f"{'; '.join(named)}."
        )
    percent = words.given(100.0 * AGREEMENT)
    near = [group for group in judgement.agreeing() if len({int(first[i]) for i in group}) > 1]
    equal = [_listed([_title(judgement, i) for i in group]) for group in near]
    if equal:
        texts.append(
            f"{name}: plans that differ, but attain the same accuracy to within {percent}\u00a0%: {'; '.join(equal)}. "
            "Which of these criteria plans does not matter here."
        )
    return texts


def _title(judgement: Judgement, index: int) -> str:
    return title(judgement.contenders[index].name, judgement.contenders[index].origin)


def _summary(
    names: Sequence[str], judgements: Sequence[Judgement], correlations: Correlations, bounds: Sequence[LowerBound]
) -> Section:
    figures, sentences = [], []
    for name, judgement, found, bound in zip(names, judgements, correlations, bounds, strict=True):
        best, attained = judgement.best, judgement.attained
        contender = judgement.contenders[best]
        label = title(contender.name, contender.origin)
        error = f"± {words.number(float(judgement.attained_standard_error[best]), 1)}, design by {label}"
        figures.append(KeyFigure(f"{name}: best accuracy", words.number(float(attained[best])), "tolerances", error))
        named = [i for i in shown(judgement) if np.isfinite(attained[i])]
        factor = judgement.attained_ratio
        near = [i for i in named if factor[i] - 2.0 * judgement.attained_ratio_standard_error[i] <= 1.01]
        worst = named[-1]
        text = (
            f"{name}: {_listed([title(judgement.contenders[i].name, judgement.contenders[i].origin) for i in near])} "
            f"{'is' if len(near) == 1 else 'are'} within 1\u00a0% of the best accuracy, to within the "
            f"statistical error of the repetitions; the least accurate of the optimised and given designs "
            f"({title(judgement.contenders[worst].name, judgement.contenders[worst].origin)}) leaves "
            f"{words.number(float(factor[worst]))} times its error"
        )
        drawn = random_ones(judgement)
        if drawn:
            middle = float(factor[drawn[len(drawn) // 2]])
            text += f", and the median of {len(drawn)} random designs {words.number(middle)} times"
        sentences.append(text + ".")
        sentences += agreement(name, judgement)
        if bound.value is not None:
            gap = 100.0 * (float(np.nanmin(judgement.values["total"])) / bound.value - 1.0)
            sentences.append(
                f"{name}: no plan of {words.count(judgement.problem.space.measurements, 'measurement')} can be "
                f"expected to leave less than {words.number(bound.value)} tolerances (lower bound of the criterion "
                f"total); the best design is within {words.number(gap, 2)}\u00a0% of that."
            )
        over = [one for one in found if one.over == "random designs" and np.isfinite(one.coefficient)]
        if over:
            order = sorted(over, key=lambda one: -one.coefficient)
            first, last = order[0], order[-1]
            sentences.append(
                f"{name}: among random designs, {words.criterion(first.criterion)} foretells the order of accuracy "
                f"best (rank correlation {_signed(first.coefficient)}), {words.criterion(last.criterion)} least "
                f"({_signed(last.coefficient)})."
            )
    return Section("summary", "In short", [KeyFigures(figures), Sentences(sentences)])


def _several(
    names: Sequence[str], judgements: Sequence[Judgement], correlations: Correlations, together: bool
) -> Section:
    blocks: list[Block] = []
    colours = ("var(--accent)", "var(--load)", "var(--recommended)", "var(--knee)", "var(--total)", "var(--noise)")
    quantity = "attained" if together else "attained_ratio"
    data = []
    for index, (name, judgement) in enumerate(zip(names, judgements, strict=True)):
        named = [i for i, contender in enumerate(judgement.contenders) if contender.origin != "random"]
        errors = getattr(judgement, f"{quantity}_standard_error")
        data.append(
            {
                "type": "bar",
                "name": plot_text(name),
                "x": [plot_text(title(judgement.contenders[i].name, judgement.contenders[i].origin)) for i in named],
                "y": getattr(judgement, quantity)[named],
                "error_y": {"type": "data", "array": errors[named]},
                "marker": {"color": colours[index % len(colours)]},
            }
        )
    unit = "attained error, tolerances" if together else "attained error / own best"
    what = (
        "Targets, tolerances and noise are the same in all configurations, so that the errors can be compared."
        if together
        else "Targets, tolerances or noise differ: each configuration is shown relative to its own best design."
    )
    layout = {"barmode": "group", "yaxis": {"title": {"text": unit}, "rangemode": "tozero"}, "showlegend": True}
    blocks.append(
        Figure(
            "per-criterion", "The design of each criterion in every configuration", {"data": data, "layout": layout},
            f"{what} Whiskers are standard errors.",
            f"Bars of the {unit} per criterion and configuration; the tables below hold the numbers.",
            filename="configurations",
        )
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
        texts = [words.number(v) if i % 2 == 0 else _signed(v) for i, v in enumerate(cells)]
        rows.append([words.criterion(criterion), *texts])
    columns = [f"{name}: {head}" for name in names for head in ("error / best", "rank correlation")]
    download = Download("criteria.csv", csv_text(pd.DataFrame(table, columns=["criterion", *columns])))
    caption = (
        "For every criterion: how many times the best design's error its own design leaves, and its rank correlation "
        "with the attained accuracy over random designs."
    )
    blocks.append(DataTable("criteria", caption, ["Criterion", *columns], rows, download))
    return Section("several", "All configurations", blocks)


def _configuration(index: int, name: str, judgement: Judgement, found: list[RankCorrelation]) -> Section:
    problem = judgement.problem
    opening = (
        f"{problem.loaded.robot.name} ({problem.loaded.robot.kind}), "
        f"{words.count(problem.space.measurements, 'measurement')}, "
        f"{words.count(len(problem.targets.weights), 'target')}."
    )
    blocks: list[Block] = [
        Paragraph(opening),
        SideBySide([_accuracy_figure(index, judgement)], [_prediction_figure(index, judgement)]),
        _cross_table(index, name, judgement),
        Subheading("How well each criterion foretells the accuracy"),
    ]
    blocks += [_correlation_figure(index, found), _correlation_table(index, name, found)] if found else []
    return Section(f"configuration-{index + 1}", name, blocks)


def _together(judgement: Judgement, index: int) -> str:
    """What a design is called, with the others of the same plan."""
    first = judgement.same_plan
    alike = [i for i in range(len(first)) if first[i] == first[index] and judgement.contenders[i].origin != "random"]
    return ", ".join(_title(judgement, i) for i in alike)


def _different(judgement: Judgement) -> list[int]:
    """Designs that are shown, each plan once."""
    first = judgement.same_plan
    rows: list[int] = []
    for i in shown(judgement):
        if all(first[i] != first[other] for other in rows):
            rows.append(i)
    return rows


def _accuracy_figure(index: int, judgement: Judgement) -> Figure:
    rows = _different(judgement)
    labels = [plot_text(_together(judgement, i)) for i in rows]
    data: list[dict[str, Any]] = [
        {
            "type": "bar", "name": "designs", "x": labels, "y": judgement.attained[rows],
            "error_y": {"type": "data", "array": judgement.attained_standard_error[rows]},
            "marker": {"color": "var(--accent)"},
        }
    ]  # fmt: skip
    drawn = random_ones(judgement)
    if drawn:
        box = {"type": "box", "name": "random", "y": judgement.attained[drawn], "marker": {"color": "var(--design)"}}
        data.append(box)
    layout = {"yaxis": {"title": {"text": "attained error, tolerances"}, "rangemode": "tozero"}, "showlegend": False}
    return Figure(
        f"accuracy-{index}", "Accuracy attained with each design", {"data": data, "layout": layout},
        "RMS error at the targets after experiment, identification and compensation. The design of each criterion is "
        "the best by this criterion alone that searches and gradients find; criteria with the same plan share a bar. "
        "Whiskers are standard errors; the box is of random "
        "designs.",
        "Bars of the attained error per design, best first; the cross table holds the numbers.",
        filename="accuracy",
    )  # fmt: skip


def _prediction_figure(index: int, judgement: Judgement) -> Figure:
    predicted, attained = judgement.values["total"], judgement.attained
    kinds = (("optimised", "var(--accent)"), ("random", "var(--design)"), ("given", "var(--load)"))
    data: list[dict[str, Any]] = []
    for origin, colour in kinds:
        rows = [i for i, contender in enumerate(judgement.contenders) if contender.origin == origin]
        if rows:
            data.append(
                {
                    "type": "scatter", "mode": "markers", "name": origin, "x": predicted[rows], "y": attained[rows],
                    "text": [plot_text(title(judgement.contenders[i].name, origin)) for i in rows],
                    "hovertemplate": "%{text}: predicted %{x:.4g}, attained %{y:.4g}<extra></extra>",
                    "marker": {"color": colour, "size": 9},
                }
            )  # fmt: skip
    ends = [float(np.nanmin(predicted)), float(np.nanmax(predicted))]
    line = {"color": "var(--muted)", "dash": "dot"}
    data.append(
        {"type": "scatter", "mode": "lines", "name": "attained = predicted", "x": ends, "y": ends, "line": line}
    )
    layout = {
        "xaxis": {"title": {"text": "predicted (criterion total), tolerances"}, "type": "log"},
        "yaxis": {"title": {"text": "attained, tolerances"}, "type": "log"},
        "showlegend": True,
    }
    return Figure(
        f"prediction-{index}", "Attained against predicted", {"data": data, "layout": layout},
        "Every point is one design. On the line the criterion total has predicted the accuracy exactly.",
        "Scatter of the attained error against the prediction; the table's CSV holds the numbers.",
        filename="prediction",
    )  # fmt: skip


def _cross_table(index: int, name: str, judgement: Judgement) -> DataTable:
    criteria = list(judgement.values)
    ratios = {criterion: judgement.ratio(criterion) for criterion in criteria}
    rows = []
    drawn = random_ones(judgement)
    picked = [(drawn[0], "best random"), (drawn[len(drawn) // 2], "median random"), (drawn[-1], "worst random")]
    for i, label in [(i, "") for i in _different(judgement)] + (picked if drawn else []):
        error = judgement.attained_ratio_standard_error[i]
        rows.append(
            [
                label or _together(judgement, i),
                f"{words.number(float(judgement.attained[i]))} ± "
                f"{words.number(float(judgement.attained_standard_error[i]), 1)}",
                f"{words.number(float(judgement.attained_ratio[i]))} ± {_small(float(error))}",
                *(words.number(float(ratios[criterion][i])) for criterion in criteria),
            ]
        )
    caption = (
        "Cross table. A row is a design, a column a criterion by which it is judged, as a ratio to the best of all "
        "designs by that criterion: 1 is the best, 2 is twice as bad. ± is one standard error. Criteria that lead to "
        "the same plan share a row."
    )
    columns = ["Design by", "Attained (tolerances)", "Attained / best", *(words.criterion(one) for one in criteria)]
    download = Download(f"comparison-{index + 1}.csv", csv_text(judgement.frame()))
    return DataTable(f"cross-{index}", caption, columns, rows, download)


def _correlation_figure(index: int, found: list[RankCorrelation]) -> Figure:
    data = []
    for over, colour in (("all designs", "var(--accent)"), ("random designs", "var(--design)")):
        ones = [one for one in found if one.over == over]
        if ones:
            value = np.array([one.coefficient for one in ones])
            whiskers = {
                "type": "data", "symmetric": False,
                "array": np.array([one.high for one in ones]) - value,
                "arrayminus": value - np.array([one.low for one in ones]),
            }  # fmt: skip
            names = [words.criterion(one.criterion) for one in ones]
            data.append(
                {
                    "type": "bar", "name": f"{over} ({ones[0].designs})", "x": names, "y": value,
                    "error_y": whiskers, "marker": {"color": colour},
                }
            )  # fmt: skip
    layout = {
        "barmode": "group", "showlegend": True,
        "yaxis": {"title": {"text": "rank correlation with accuracy"}, "range": [-1.05, 1.05]},
    }  # fmt: skip
    return Figure(
        f"correlation-{index}", "Rank correlation with the attained accuracy", {"data": data, "layout": layout},
        "1: the criterion puts the designs in the order of the accuracy that they attain; 0: it says nothing about "
        "it; below 0: it prefers the less accurate. Whiskers are 95 % intervals.",
        "Bars of the rank correlation per criterion; the table below holds the numbers.",
        filename="correlation",
    )  # fmt: skip


def _correlation_table(index: int, name: str, found: list[RankCorrelation]) -> DataTable:
    rows = [
        [words.criterion(o.criterion), o.over, str(o.designs), _signed(o.coefficient), _signed(o.low), _signed(o.high)]
        for o in found
    ]
    columns = ["Criterion", "Over", "Designs", "Rank correlation", "95 % from", "to"]
    download = Download(f"correlation-{index + 1}.csv", csv_text(pd.DataFrame([vars(one) for one in found])))
    caption = "Spearman's rank correlation of each criterion with the attained accuracy."
    return DataTable(f"correlations-{index}", caption, columns, rows, download, tall=True)


def _settings(judgements: Sequence[Judgement], how: Mapping[str, str]) -> Section:
    sources = ", ".join(judgement.problem.source for judgement in judgements)
    return Section("run", "About this comparison", [Definitions([("Configurations", sources), *how.items()])])


def _listed(items: Sequence[str]) -> str:
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} and {items[-1]}"


def _small(error: float) -> str:
    return "<\u202f0.001" if error < 0.0005 else words.number(error, 1)


def _signed(value: float) -> str:
    return words.UNDETERMINED if np.isnan(value) else words.fixed(value, 2)


_WORDS = [
    (
        "Design by X",
        "The plan that is best by criterion X alone, as its own author would choose it, of all that were found: "
        "searched for every criterion, then refined along its gradient to a local optimum.",
    ),
    (
        "Attained",
        "What is left at the targets after experiment, identification and exact compensation, repeated with noise and "
        "load errors drawn anew: RMS over the repetitions, in tolerances. Every design meets the same draws.",
    ),
    ("Tolerance", "The error that the configuration accepts on an axis of a target. 1 tolerance = just acceptable."),
    ("DUIR, FEIR, total", "Error at the targets from measurement noise, from load errors, and from both."),
    ("O1 to O5", "Observability indices: how well all stiffnesses are determined, wherever the targets are."),
    ("O_TP, O_MV", "Variance of the attained position due to noise: at the first target, and over the targets."),
    ("Rank correlation", "Spearman's: whether two quantities put designs in the same order, from −1 to 1."),
    ("Random designs", "Measurements drawn evenly from all that the robot can reach."),
]
