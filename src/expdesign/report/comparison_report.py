"""What `compare` returns and its page: which criterion's design is accurate, and how well each predicts it."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import ClassVar

import numpy as np
import pandas as pd

from expdesign.assurance.comparison.correlation import RankCorrelation
from expdesign.assurance.comparison.judgement import AGREEMENT, Judgement
from expdesign.errors import InputError
from expdesign.planning.optimality.certificate import LowerBound
from expdesign.planning.plan import plan_frame
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
from expdesign.report.result import PAGE, FolderResult
from expdesign.report.said import Said

_WORDS = ("Design by X", "Attained", "Tolerance", "DUIR", "FEIR", "total", "O1 to O5", "O_TP, O_MV", "Rank correlation",
          "Random designs")  # fmt: skip

_NO_FILE = re.compile(r"[^\w.-]")
"""Characters of a configuration's name that stand in no name of a file."""


@dataclass(frozen=True, repr=False)
class ComparisonResult(FolderResult):
    """A finished comparison.

    Attributes:
        names: of the configurations.
        judgements: one per configuration.
        correlations: of each configuration.
        bounds: on the criterion `total` of every plan of each configuration's number of measurements.
        together: whether their accuracies mean the same, so that they are laid over each other.
        settings: how it was made: names and values in words.
    """

    FILES: ClassVar = {"comparison.csv": "frame", "correlation.csv": "correlation", "plan-*.csv": "optimised", **PAGE}
    names: tuple[str, ...]
    judgements: tuple[Judgement, ...]
    correlations: tuple[list[RankCorrelation], ...]
    bounds: tuple[LowerBound, ...]
    together: bool
    settings: Mapping[str, str]

    @property
    def said(self) -> Said:
        summaries, texts = [], []
        each = zip(self.names, self.judgements, self.correlations, self.bounds, strict=True)
        for name, judgement, found, bound in each:
            best = judgement.best
            attained = f"{judgement.attained[best]:.4g} ± {judgement.attained_standard_error[best]:.2g} tolerances"
            summaries.append(f"{name}: best accuracy {attained}, design by {designs(judgement)['title'][best]}")
            further = [*_near(judgement), *agreement(judgement), *_bounded(judgement, bound), *_predicting(found)]
            texts += [f"{summaries[-1]}.", *(f"{name}: {text}" for text in further)]
        return Said("\n".join(summaries), texts)

    @property
    def frame(self) -> pd.DataFrame:
        """One row per configuration and design (`comparison.csv`): values, accuracy, and ratios to the best."""
        frames = []
        for name, judgement, bound in zip(self.names, self.judgements, self.bounds, strict=True):
            frame = judgement.frame()
            frame.insert(0, "configuration", name)
            frame.insert(1, "robot", judgement.problem.loaded.robot.name)
            value = bound.value if bound.value is not None else float("nan")
            frame["total_lower_bound"] = np.where(judgement.longer, np.nan, value)
            frames.append(frame)
        return pd.concat(frames, ignore_index=True)

    @property
    def correlation(self) -> pd.DataFrame:
        """Rank correlation of every criterion with the attained accuracy (`correlation.csv`)."""
        pairs = zip(self.names, self.correlations, strict=True)
        return pd.DataFrame([{"configuration": name} | asdict(one) for name, found in pairs for one in found])

    def plan(self, configuration: str, design: str) -> pd.DataFrame:
        """The plan of a design by the names in `frame`."""
        for name, judgement in zip(self.names, self.judgements, strict=True):
            for contender in judgement.contenders:
                if (name, contender.name) == (configuration, design):
                    return plan_frame(contender.plan, judgement.problem.loaded, judgement.problem.space.tilts)
        remedy = "The columns `configuration` and `design` of the frame have the names."
        raise InputError(f"there is no design `{design}` of `{configuration}`", remedy=remedy)

    @property
    def optimised(self) -> dict[str, pd.DataFrame]:
        """The plans that are best by a criterion, by the names of their files."""
        return {
            f"plan-{_NO_FILE.sub('-', name)}-{contender.name}.csv": self.plan(name, contender.name)
            for name, judgement in zip(self.names, self.judgements, strict=True)
            for contender in judgement.contenders
            if contender.origin == "optimised"
        }

    def page(self) -> Page:
        names, judgements = self.names, self.judgements
        sections = [self.said.section("In short", _key_figures(names, judgements), id="summary")]
        if len(names) > 1:
            sections.append(all_configurations(names, judgements, self.correlations, self.together))
        for index, (name, judgement, found) in enumerate(zip(names, judgements, self.correlations, strict=True)):
            sections.append(_configuration(index, name, judgement, found))
        settings = [("Configurations", ", ".join(one.problem.source for one in judgements)), *self.settings.items()]
        sections.append(words_section(*_WORDS))
        sections.append(PageSection("run", "About this comparison", [Definitions(settings)]))
        robots = ", ".join(dict.fromkeys(judgement.problem.loaded.robot.name for judgement in judgements))
        count = words.count(sum(len(judgement.contenders) for judgement in judgements), "design")
        return Page("Comparison of criteria", f"{robots}; {count} of {', '.join(names)}", sections)


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


def _near(judgement: Judgement) -> list[str]:
    """Designs whose accuracy cannot be told from the best, and how far the others are from it."""
    own, drawn = named(judgement), random_ones(judgement)
    own = own[np.isfinite(own["attained"])]
    if own.empty:  # none of them identifies what the targets need
        return []
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
