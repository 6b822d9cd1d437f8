"""The page of `expdesign compare`: which criterion's design is accurate, and how well each criterion predicts it."""

from collections.abc import Mapping, Sequence

import numpy as np

from expdesign.assurance.comparison.correlation import RankCorrelation
from expdesign.assurance.comparison.judgement import AGREEMENT, Judgement
from expdesign.planning.optimality.certificate import LowerBound
from expdesign.report import words
from expdesign.report.blocks import (
    Block,
    Definitions,
    KeyFigure,
    KeyFigures,
    PageSection,
    Paragraph,
    SideBySide,
    Subheading,
)
from expdesign.report.comparison_figures import (
    Correlations,
    accuracy_figure,
    all_configurations,
    correlation_figure,
    correlation_table,
    cross_table,
    designs,
    named,
    prediction_figure,
    random_ones,
    signed,
)
from expdesign.report.glossary import words_section
from expdesign.report.page import Page
from expdesign.report.said import Said

_WORDS = ("Design by X", "Attained", "Tolerance", "DUIR", "FEIR", "total", "O1 to O5", "O_TP, O_MV", "Rank correlation",
          "Random designs")  # fmt: skip


def comparison_report(
    names: Sequence[str],
    judgements: Sequence[Judgement],
    correlations: Correlations,
    said: Said,
    together: bool,
    how: Mapping[str, str],
) -> Page:
    """The report of a comparison.

    Args:
        names: of the configurations.
        judgements: one per configuration.
        correlations: of each configuration.
        said: what is said of them (`compared`).
        together: whether accuracies of different configurations mean the same.
        how: settings and their values, for the last section.
    """
    sections = [said.section("In short", _key_figures(names, judgements), id="summary")]
    if len(names) > 1:
        sections.append(all_configurations(names, judgements, correlations, together))
    for index, (name, judgement, found) in enumerate(zip(names, judgements, correlations, strict=True)):
        sections.append(_configuration(index, name, judgement, found))
    settings = [("Configurations", ", ".join(one.problem.source for one in judgements)), *how.items()]
    sections.append(words_section(*_WORDS))
    sections.append(PageSection("run", "About this comparison", [Definitions(settings)]))
    robots = ", ".join(dict.fromkeys(judgement.problem.loaded.robot.name for judgement in judgements))
    designs = words.count(sum(len(judgement.contenders) for judgement in judgements), "design")
    return Page("Comparison of criteria", f"{robots}; {designs} of {', '.join(names)}", sections)


def agreement(judgement: Judgement) -> list[str]:
    """Which criteria lead to the very same plan, and which to plans of the same accuracy."""
    frame, texts = designs(judgement).sort_index(), []
    plans = [group["title"].tolist() for _, group in frame[frame["origin"] == "optimised"].groupby("plan", sort=False)]
    alike = [words.listed(titles) for titles in plans if len(titles) > 1]
    if alike:
        count = words.count(len(plans), "different plan")
        texts.append(
            f"the {sum(map(len, plans))} criteria lead to {count}. The same plan to the last measurement: "
            f"{'; '.join(alike)}."
        )
    near = [frame.loc[group] for group in judgement.agreeing()]
    equal = [words.listed(group["title"].tolist()) for group in near if group["plan"].nunique() > 1]
    if equal:
        percent = words.given(100.0 * AGREEMENT)
        texts.append(
            f"plans that differ, but attain the same accuracy to within {percent}\u00a0%: {'; '.join(equal)}. Which of "
            "these criteria plans does not matter here."
        )
    return texts


def compared(
    names: Sequence[str], judgements: Sequence[Judgement], correlations: Correlations, bounds: Sequence[LowerBound]
) -> Said:
    """What `compare` says of every configuration: the best accuracy, what else comes near, and what predicts it.

    Args:
        names: of the configurations.
        judgements: one per configuration.
        correlations: of each configuration.
        bounds: on the criterion `total` of every plan.
    """
    summaries, texts = [], []
    for name, judgement, found, bound in zip(names, judgements, correlations, bounds, strict=True):
        best = judgement.best
        attained = f"{judgement.attained[best]:.4g} ± {judgement.attained_standard_error[best]:.2g} tolerances"
        summaries.append(f"{name}: best accuracy {attained}, design by {designs(judgement)['title'][best]}")
        further = [*_near(judgement), *agreement(judgement), *_bounded(judgement, bound), *_predicting(found)]
        texts += [f"{summaries[-1]}.", *(f"{name}: {text}" for text in further)]
    return Said("\n".join(summaries), texts)


def _near(judgement: Judgement) -> list[str]:
    """Designs whose accuracy cannot be told from the best, and how far the others are from it."""
    own, drawn = named(judgement), random_ones(judgement)
    own = own[np.isfinite(own["attained"])]
    near = own[own["attained_ratio"] - 2.0 * own["attained_ratio_standard_error"] <= 1.01]
    worst = own.iloc[-1]
    text = (
        f"{words.listed(near['title'].tolist())} {'is' if len(near) == 1 else 'are'} within 1\u00a0% of the best "
        "accuracy, to within the statistical error of the repetitions; the least accurate of the optimised and given "
        f"designs ({worst['title']}) leaves {words.number(float(worst['attained_ratio']))} times its error"
    )
    if len(drawn):
        middle = float(drawn["attained_ratio"].iloc[len(drawn) // 2])
        text += f", and the median of {len(drawn)} random designs {words.number(middle)} times"
    return [f"{text}."]


def _bounded(judgement: Judgement, bound: LowerBound) -> list[str]:
    if bound.value is None:
        return []
    longer, count = judgement.longer, words.count(judgement.problem.space.measurements, "measurement")
    text = (
        f"no plan of {count} can be expected to leave less than {words.number(bound.value)} tolerances (lower bound of "
        "the criterion total)"
    )
    totals = judgement.values["total"][~longer]
    if np.isfinite(totals).any():
        gap = 100.0 * (float(np.nanmin(totals)) / bound.value - 1.0)
        text += (
            f"; the best design {'of them ' if longer.any() else ''}is {words.number(gap, 2)}\u00a0% above this bound"
        )
    own = [one for one, more in zip(judgement.contenders, longer, strict=True) if more]
    if own:
        listed = words.listed([f"{one.name} ({len(one.plan)})" for one in own])
        text += f". It does not bound designs with more measurements: {listed}"
    return [f"{text}."]


def _predicting(found: list[RankCorrelation]) -> list[str]:
    over = [one for one in found if one.over == "random designs" and np.isfinite(one.coefficient)]
    if not over:
        return []
    order = sorted(over, key=lambda one: -one.coefficient)
    first, last = order[0], order[-1]
    return [
        f"among random designs, {words.criterion(first.criterion)} predicts the order of accuracy best (rank "
        f"correlation {signed(first.coefficient)}), {words.criterion(last.criterion)} least "
        f"({signed(last.coefficient)})."
    ]


def _key_figures(names: Sequence[str], judgements: Sequence[Judgement]) -> KeyFigures:
    figures = []
    for name, judgement in zip(names, judgements, strict=True):
        best = judgement.best
        error = words.number(float(judgement.attained_standard_error[best]), 1)
        note = f"± {error}, design by {designs(judgement)['title'][best]}"
        value = words.number(float(judgement.attained[best]))
        figures.append(KeyFigure(f"{name}: best accuracy", value, "tolerances", note))
    return KeyFigures(figures)


def _configuration(index: int, name: str, judgement: Judgement, found: list[RankCorrelation]) -> PageSection:
    problem = judgement.problem
    opening = (
        f"{problem.loaded.robot.name} ({problem.loaded.robot.kind}), "
        f"{words.count(problem.space.measurements, 'measurement')}, "
        f"{words.count(len(problem.targets.weights), 'target')}."
    )
    blocks: list[Block] = [
        Paragraph(opening),
        SideBySide([accuracy_figure(index, judgement)], [prediction_figure(index, judgement)]),
        cross_table(index, judgement),
        Subheading("How well each criterion predicts the accuracy"),
    ]
    blocks += [correlation_figure(index, found), correlation_table(index, found)] if found else []
    return PageSection(f"configuration-{index + 1}", name, blocks)
