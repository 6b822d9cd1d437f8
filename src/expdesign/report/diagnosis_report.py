"""The page of `expdesign diagnose`: what is wrong, where, how sure that is, and how much better the model is now."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

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
from expdesign.report.diagnosis_texts import MEASURE_NEXT, in_prose, located, next_recording
from expdesign.report.glossary import words_section
from expdesign.report.next_steps import next_steps
from expdesign.report.page import Page
from expdesign.report.physics_words import effect_words, physics_words
from expdesign.report.robot_section import SCRIPTS, picture
from expdesign.report.robot_view import at_rest
from expdesign.report.said import Said

_MODELS = 60
"""In the table of what was considered."""


def diagnosis_report(
    result: Diagnosis,
    said: Said,
    at_targets: Sequence[PageSection] = (),
    configuration: str = "",
    acceptance: KeyFigure | None = None,
) -> Page:
    """The report of a diagnosis.

    Args:
        result: what was found.
        said: what is said of it (`diagnosed`).
        at_targets: sections about the targets.
        configuration: path of the run configuration that has them.
        acceptance: the verdict there.
    """
    drawn, data = _picture(result)
    consistent = result.verdict == "consistent"
    found = [_effects_table(result)] if any(finding.parameters for finding in result.findings) else []
    first = next_recording(result)
    first += [MEASURE_NEXT] if result.rival is not None else []
    recordings = result.recordings.source
    errors = SideBySide([error_figure(result)], [axis_figure(result)])
    sections = (
        said.section("Result", _key_figures(result, acceptance)),
        PageSection("physics", "What was left out", [*found, *said.tables]),
        PageSection("laws", "Laws at ports", law_blocks(result)),
        PageSection("where", "Where the mismatch is", [] if consistent else [*drawn, *_where(result)]),
        *at_targets,
        PageSection("errors", "Before and after" if added(result) else "Errors", [errors]),
        PageSection("residuals", "Residuals", residual_figures(result)),
        PageSection("machine", "The robot", drawn if consistent else []),
        PageSection("considered", "What was considered", _considered(result)),
        next_steps(*first, "predict", "compensate", "verify", config=configuration, recordings=recordings),
        words_section("Base model", "Standard deviation", "Held out", "Probability"),
    )
    rows = len(result.recordings)
    return Page(
        title=f"Diagnosis of {result.robot.name}",
        subtitle=f"{result.robot.kind}, {words.count(rows, 'row')}; recordings {recordings}",
        sections=sections,
        data=data,
        scripts=SCRIPTS if data else (),
    )


def _picture(result: Diagnosis) -> tuple[list[Block], dict[str, object]]:
    """The robot at the middle of the recorded poses, with the components that are concerned."""
    middle = np.median(result.recordings.configurations, axis=0)
    concerned = [] if result.verdict == "consistent" else located(result)
    note = "The robot at the middle of the recorded poses."
    if concerned:
        note += f" The mismatch points to {words.listed(concerned)}."
    return picture(result.robot, at_rest(result.robot, middle), concerned, note)


def _key_figures(result: Diagnosis, acceptance: KeyFigure | None) -> KeyFigures:
    errors, unit, note = result.errors, "standard deviations", "RMS; 1 is the noise"
    items = [
        KeyFigure("Verdict", result.verdict),
        *([] if acceptance is None else [acceptance]),
        KeyFigure("Held out, base model", words.number(errors.test_before), unit, note),
        KeyFigure("Models tried", str(len(result.names.tried))),
    ]
    if added(result):
        items.insert(-1, KeyFigure("Held out, now", words.number(errors.test_after), unit, note))
    return KeyFigures(items)


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
