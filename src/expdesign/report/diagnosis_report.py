"""What `diagnose` returns and its page: what is wrong, where, how sure that is, and how much better the model is."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from expdesign.diagnosis.law_findings import curves
from expdesign.diagnosis.next_experiment import discriminating_series
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.result import Diagnosis
from expdesign.probabilities import probability_text
from expdesign.report import words
from expdesign.report.blocks import (
    Block,
    DataTable,
    KeyFigure,
    KeyFigures,
    PageSection,
    Paragraph,
    Shown,
    SideBySide,
    framed,
    number_of,
    table_of,
)
from expdesign.report.diagnosis_figures import added, axis_figure, error_figure, law_blocks, residual_figures
from expdesign.report.diagnosis_texts import (
    IN_DOUBT,
    VERDICTS,
    diagnosis_record,
    finding_sentence,
    held_out_sentences,
    in_prose,
    located,
    mismatch,
    next_recording,
)
from expdesign.report.fit_texts import diagnosed_fit_sentences
from expdesign.report.glossary import words_section
from expdesign.report.next_steps import next_steps
from expdesign.report.page import Page
from expdesign.report.physics_words import effect_words, physics_words
from expdesign.report.remark_texts import sentences
from expdesign.report.result import PAGE, RecordedResult
from expdesign.report.robot_section import SCRIPTS, picture
from expdesign.report.robot_view import at_rest
from expdesign.report.said import Said
from expdesign.report.stiffness import added_physics, diagnosed_stiffness, stiffness_table

_MODELS = 60
"""In the table of what was considered."""


NEXT_PLAN = "plan-next.csv"
_ENDED = "Ended by hand during this step: {}. This is the best model so far; a finished diagnosis may differ."
_MEASURE_NEXT = "Measure plan-next.csv: it separates the two remaining explanations."


@dataclass(frozen=True, repr=False)
class DiagnosisResult(RecordedResult):
    """A diagnosis; `model` has the effects that were found, `at_targets` what may be hidden where all is consistent.

    Attributes:
        result: everything that the diagnosis found.
        series: number of series of a plan that separates two explanations.
    """

    FILES: ClassVar = {
        "model.yaml": "model",
        "diagnosis.json": "record",
        NEXT_PLAN: "next_plan",
        "law-*.csv": "laws",
        **PAGE,
    }
    result: Diagnosis
    series: int

    @property
    def refused(self) -> bool:
        """Whether what was diagnosed is no robot: the recordings fit only if they are read otherwise."""
        return any(doubt.otherwise for doubt in self.result.doubts)

    @property
    def said(self) -> Said:
        result, plan = self.result, None if self.result.rival is None else NEXT_PLAN
        further = Said("", []) if self.at_targets is None else self.at_targets.said
        verdict = IN_DOUBT if result.doubts and result.verdict == "unexplained" else VERDICTS[result.verdict]
        ended = [_ENDED.format(result.ended)] if result.ended else []
        texts = [*ended, f"Verdict: {result.verdict}. {verdict}"]
        texts += sentences(result.doubts)
        texts += [finding_sentence(one) for one in result.findings]
        texts += [mismatch(result)] if result.verdict != "consistent" else []
        texts += next_recording(result)
        texts += [*diagnosed_fit_sentences(result), *held_out_sentences(result), *sentences(result.caveats)]
        if not result.noise.known:
            texts.append("The recordings state no standard deviations: the verdict rests on held-out error.")
        texts += [*further.sentences, *self._measure_next]
        there = [f"{each.physics} at {each.component}" for each in result.findings]
        about = "with this physics in the model, with 95 % intervals, and of the base model (springs alone)."
        frame = diagnosed_stiffness(result) if added_physics(result) else None
        return Said(
            ", ".join([*(["ended by hand"] if result.ended else []), result.verdict, *there]),
            texts,
            ["interrupted: the best model so far is written"] if result.ended else [],
            lambda: diagnosis_record(result, plan) | dict(further.document()),
            [] if frame is None else [stiffness_table(frame, result.robot, about)],
        )

    @property
    def _measure_next(self) -> list[str]:
        """What separates two explanations that remain."""
        return [] if self.result.rival is None else [_MEASURE_NEXT]

    @property
    def verdict(self) -> str:
        """`consistent`, `explained`, `modelled` or `unexplained`."""
        return self.result.verdict

    @property
    def chi2(self) -> float | None:
        """χ² of the base model; None where the noise was estimated from the recordings."""
        return self.result.before.chi2

    @property
    def p_value(self) -> float | None:
        """Probability of a χ² as large as this if the base model is right; None where there is no test."""
        return self.result.before.p_value

    @property
    def effects(self) -> pd.DataFrame:
        """The effects that are present together: physics, component, probability and what it does."""
        columns = ("physics", "component", "variant", "probability", "sentence")
        rows = [[getattr(finding, name) for name in columns] for finding in self.result.findings]
        return pd.DataFrame(rows, columns=list(columns))

    @property
    def next_plan(self) -> pd.DataFrame | None:
        """A plan that separates two explanations, where two remain; else None."""
        rival = self.result.rival
        if rival is None:
            return None
        return discriminating_series(self.result.names, self.result.model, rival, self.series)

    @property
    def laws(self) -> dict[str, pd.DataFrame]:
        """The curves of the laws that were found, by the names of their files."""
        return {
            f"law-{number}.csv": finding.curve.frame(list(finding.columns))
            for number, finding in enumerate(curves(self.result.findings), start=1)
            if finding.curve is not None
        }

    def page(self) -> Page:
        result, said, at = self.result, self.said, self.at_targets
        drawn, data = _picture(result)
        consistent = result.verdict == "consistent"
        found = [_effects_table(result)] if any(finding.parameters for finding in result.findings) else []
        first = [*next_recording(result), *self._measure_next]
        files = {"config": "" if at is None else at.problem.source, "recordings": result.recordings.source}
        errors = SideBySide([error_figure(result)], [axis_figure(result)])
        sections = (
            said.section("Result", self._key_figures()),
            PageSection("physics", "What was left out", [*found, *said.tables]),
            PageSection("laws", "Laws at ports", law_blocks(result)),
            PageSection("where", "Where the mismatch is", [] if consistent else [*drawn, *_where(result)]),
            *([] if at is None else at.sections("the diagnosed model")),
            PageSection("errors", "Before and after" if added(result) else "Errors", [errors]),
            PageSection("residuals", "Residuals", residual_figures(result)),
            PageSection("machine", "The robot", drawn if consistent else []),
            PageSection("considered", "What was considered", _considered(result)),
            next_steps(*first, "predict", "compensate", "verify", **files),
            words_section("Base model", "Standard deviation", "Held out", "Probability"),
        )
        rows = words.count(len(result.recordings), "row")
        return Page(
            title=f"Diagnosis of {result.robot.name}",
            subtitle=f"{result.robot.kind}, {rows}; recordings {result.recordings.source}",
            sections=sections,
            data=data,
            scripts=SCRIPTS if data else (),
        )

    def _key_figures(self) -> KeyFigures:
        result, at = self.result, self.at_targets
        errors, unit, note = result.errors, "standard deviations", "RMS; 1 is the noise"
        items = [
            KeyFigure("Verdict", result.verdict),
            *([] if at is None else [at.figure]),
            KeyFigure("Held out, base model", words.number(errors.test_before), unit, note),
            KeyFigure("Models tried", str(len(result.names.tried))),
        ]
        if added(result):
            items.insert(-1, KeyFigure("Held out, now", words.number(errors.test_after), unit, note))
        return KeyFigures(items)


def _picture(result: Diagnosis) -> tuple[list[Block], dict[str, object]]:
    """The robot at the middle of the recorded poses, with the components that are concerned."""
    middle = np.median(result.recordings.configurations, axis=0)
    concerned = [] if result.verdict == "consistent" else located(result)
    note = "The robot at the middle of the recorded poses."
    if concerned:
        note += f" The mismatch points to {words.listed(concerned)}."
    return picture(result.robot, at_rest(result.robot, middle), concerned, note)


def _effects_table(result: Diagnosis) -> DataTable:
    records = [
        [finding.physics, finding.component, finding.variant, name, *values, finding.probability]
        for finding in result.findings
        for name, values in finding.parameters.items()
    ]
    columns = ["physics", "component", "variant", "parameter", "value", "low", "high", "probability"]

    def numbers(row: Any, *values: float) -> str:
        return " to ".join(words.number(words.parameter(row.parameter, row.value).factor * value) for value in values)

    shown: Shown = {
        "Physics": lambda row: physics_words(row.physics, row.component),
        "Component": "component",
        "Parameter": lambda row: words.parameter(row.parameter, row.value).heading,
        "Value": lambda row: numbers(row, row.value),
        "95 % interval": lambda row: numbers(row, row.low, row.high) if abs(row.high) < 1e299 else words.UNDETERMINED,
        "Probability": lambda row: probability_text(row.probability, 2),
    }
    caption = "Physics added to the model, with 95 % intervals. The CSV is in SI units."
    return framed("effects", caption, pd.DataFrame(records, columns=columns), shown)


def _where(result: Diagnosis) -> list[Block]:
    location = result.location
    kinds = {"part of the machine": location.components, "dependence": location.patterns}
    frame = pd.DataFrame([{"kind": kind, **vars(probe)} for kind, probes in kinds.items() for probe in probes])
    caption = (
        "How much of χ² any cause in that place, or any straight line or parabola in that quantity, would explain. "
        "p is corrected for the number of tests in its group."
    )
    shown: Shown = {
        "Where": lambda row: in_prose(row.name),
        "Kind": "kind",
        "Explains": number_of("explained", digits=4),
        "Directions": "dimension",
        "p": lambda row: probability_text(row.p_value, 2),
        "": lambda row: "stands out" if row.p_value < OPTIONS.level else "",
    }
    table = framed("probes", caption, frame, shown, tall=True)
    return [Paragraph("Tests of the base model's residuals, before any physics is named."), table]


def _considered(result: Diagnosis) -> list[Block]:
    entries = result.names.log.entries
    rows = []
    for entry in entries[:_MODELS]:
        effects = entry["effects"]
        assert isinstance(effects, list)
        physics = "; ".join(map(effect_words, effects)) or "base model"
        fitted = [_shown(entry["chi2"]), _shown(entry["penalised_misfit"]), "kept" if entry["kept"] else "not kept"]
        rows.append([str(entry["step"]), physics, *fitted, str(entry["reason"])])
    frame = pd.DataFrame([{**entry, "effects": "; ".join(entry["effects"])} for entry in entries])  # type: ignore[arg-type]
    part = f" The first {_MODELS} of {len(entries)}; the CSV has all." if len(entries) > _MODELS else ""
    caption = (
        "Models that were fitted in full, and why each was kept or not. The penalised misfit is −2·log of evidence and "
        "prior: it charges every effect for its parameters and for the places at which it was looked for."
    )
    heads = ["Step", "Physics", "χ²", "Penalised misfit", "", "Reason"]
    how = Paragraph(f"Way of working: {result.method.name}, because {result.method.reason}.")
    return [how, table_of("considered-table", caption + part, heads, rows, frame if entries else None, tall=True)]


def _shown(value: object) -> str:
    """A number of the log, or nothing where the entry concerns no single model."""
    return "" if value is None else words.number(float(str(value)), 5)
