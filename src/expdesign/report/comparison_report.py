"""The page of `expdesign compare`: which criterion's design is accurate, and how well each criterion foretells it."""

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
    Sentences,
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
    prediction_figure,
    random_ones,
    shown,
    signed,
    title_of,
)
from expdesign.report.page import Page
from expdesign.report.said import Said


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
        sections.append(all_configurations(names, judgements, correlations, together))
    for index, (name, judgement, found) in enumerate(zip(names, judgements, correlations, strict=True)):
        sections.append(_configuration(index, name, judgement, found))
    settings = [("Configurations", ", ".join(one.problem.source for one in judgements)), *how.items()]
    sections.append(PageSection("words", "What the words mean", [Definitions(_WORDS)]))
    sections.append(PageSection("run", "About this comparison", [Definitions(settings)]))
    robots = ", ".join(dict.fromkeys(judgement.problem.loaded.robot.name for judgement in judgements))
    designs = words.count(sum(len(judgement.contenders) for judgement in judgements), "design")
    return Page("Comparison of criteria", f"{robots}; {designs} of {', '.join(names)}", sections)


def agreement(name: str, judgement: Judgement) -> list[str]:
    """Which criteria lead to the very same plan, and which to plans of the same accuracy."""
    first, texts = judgement.same_plan, []
    optimised = [i for i, one in enumerate(judgement.contenders) if one.origin == "optimised"]
    alike = [[i for i in optimised if first[i] == leader] for leader in dict.fromkeys(int(first[i]) for i in optimised)]
    named = [words.listed([title_of(judgement, i) for i in group]) for group in alike if len(group) > 1]
    if named:
        count = words.count(len(alike), "different plan")
        texts.append(
            f"{name}: the {len(optimised)} criteria lead to {count}. The same plan to the last measurement: "
            f"{'; '.join(named)}."
        )
    percent = words.given(100.0 * AGREEMENT)
    near = [group for group in judgement.agreeing() if len({int(first[i]) for i in group}) > 1]
    equal = [words.listed([title_of(judgement, i) for i in group]) for group in near]
    if equal:
        texts.append(
            f"{name}: plans that differ, but attain the same accuracy to within {percent}\u00a0%: {'; '.join(equal)}. "
            "Which of these criteria plans does not matter here."
        )
    return texts


def compared(names: Sequence[str], judgements: Sequence[Judgement]) -> Said:
    """What `compare` says: the best accuracy of every configuration, and the design that attains it."""
    lines = []
    for name, judgement in zip(names, judgements, strict=True):
        best = judgement.best
        attained = f"{judgement.attained[best]:.4g} ± {judgement.attained_standard_error[best]:.2g} tolerances"
        lines.append(f"{name}: best accuracy {attained}, design by {judgement.contenders[best].name}")
    return Said("\n".join(lines))


def _summary(
    names: Sequence[str], judgements: Sequence[Judgement], correlations: Correlations, bounds: Sequence[LowerBound]
) -> PageSection:
    figures, sentences = [], []
    for name, judgement, found, bound in zip(names, judgements, correlations, bounds, strict=True):
        best, attained = judgement.best, judgement.attained
        error = words.number(float(judgement.attained_standard_error[best]), 1)
        error = f"± {error}, design by {title_of(judgement, best)}"
        figures.append(KeyFigure(f"{name}: best accuracy", words.number(float(attained[best])), "tolerances", error))
        named = [i for i in shown(judgement) if np.isfinite(attained[i])]
        factor = judgement.attained_ratio
        near = [i for i in named if factor[i] - 2.0 * judgement.attained_ratio_standard_error[i] <= 1.01]
        worst = named[-1]
        text = (
            f"{name}: {words.listed([title_of(judgement, i) for i in near])} "
            f"{'is' if len(near) == 1 else 'are'} within 1\u00a0% of the best accuracy, to within the "
            f"statistical error of the repetitions; the least accurate of the optimised and given designs "
            f"({title_of(judgement, worst)}) leaves "
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
                f"total); the best design is {words.number(gap, 2)}\u00a0% above this bound."
            )
        over = [one for one in found if one.over == "random designs" and np.isfinite(one.coefficient)]
        if over:
            order = sorted(over, key=lambda one: -one.coefficient)
            first, last = order[0], order[-1]
            sentences.append(
                f"{name}: among random designs, {words.criterion(first.criterion)} foretells the order of accuracy "
                f"best (rank correlation {signed(first.coefficient)}), {words.criterion(last.criterion)} least "
                f"({signed(last.coefficient)})."
            )
    return PageSection("summary", "In short", [KeyFigures(figures), Sentences(sentences)])


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
        Subheading("How well each criterion foretells the accuracy"),
    ]
    blocks += [correlation_figure(index, found), correlation_table(index, found)] if found else []
    return PageSection(f"configuration-{index + 1}", name, blocks)


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
