"""The certificate of `expdesign verify`: what was attained, against prediction and tolerance, and who signs for it."""

from collections.abc import Mapping, Sequence

import pandas as pd

from expdesign.acceptance.about import About
from expdesign.acceptance.check_measurement import CheckMeasurement
from expdesign.acceptance.record import RULE
from expdesign.acceptance.verification import AxisResult, Verification
from expdesign.files.csv_writer import csv_text
from expdesign.models.model_file import Model
from expdesign.report import words
from expdesign.report.blocks import (
    DataTable,
    Definitions,
    Download,
    KeyFigure,
    KeyFigures,
    Paragraph,
    Section,
    Sentences,
)
from expdesign.report.page import Page

_BLANK = "_" * 40
_VERDICTS = {"pass": "pass", "fail": "fail", "no tolerance": "no decision"}


def verification_report(
    result: Verification, model: Model, check: CheckMeasurement, about: About, files: Mapping[str, str]
) -> Page:
    """The certificate, one page to be printed and signed.

    Args:
        result: what was found.
        model: of the robot.
        check: what was measured.
        about: who measured what, with what, where and when.
        files: SHA-256 of every file, by its name.
    """
    robot = model.chain.robot
    sections = (
        Section("statement", "Statement", (_figures(result), Sentences(statement(result)))),
        Section("subject", "Subject", (Definitions(_subject(model, check, about)),)),
        Section("results", "Results", (_table(result, model), Paragraph(_rule(result)))),
        Section("files", "Files", (_files(files),)),
        Section("signature", "Signature", (Definitions((("Date", _BLANK), ("Name and signature", _BLANK))),)),
    )
    return Page(
        title=f"Certificate of verification: {about.robot or robot.name}",
        subtitle=f"Accuracy under load after compensation, {words.count(len(check), 'check measurement')}",
        sections=sections,
        footer="Made by expdesign.",
    )


def statement(result: Verification) -> list[str]:
    """What is certified, in words."""
    axes = [axis for target in result.targets for axis in target.axes if axis.tolerance is not None]
    proven = sum(axis.conformity == "conforms" for axis in axes)
    texts = []
    if result.verdict == "pass":
        texts.append(f"The robot passes: all {len(axes)} axes with a tolerance conform at every target.")
    elif result.verdict == "fail":
        beyond = sum(axis.conformity == "does not conform" for axis in axes)
        texts.append(
            f"The robot fails: of {len(axes)} axes with a tolerance {proven} conform, {beyond} do not conform, and for "
            f"{len(axes) - proven - beyond} conformity is not proven."
        )
    else:
        texts.append("No tolerance was stated, so that nothing is decided.")
    needed = [target.measurements_needed for target in result.targets if not target.passes]
    if result.verdict == "fail" and needed and None not in needed:
        most = max(count for count in needed if count is not None)
        texts.append(
            f"If the mean errors stay as they are, {most} independent readings of every target would prove conformity."
        )
    missed = sum(len(target.rows) == 0 for target in result.targets)
    if missed:
        texts.append(
            f"{words.count(missed, 'target')} of the configuration {'was' if missed == 1 else 'were'} not measured."
        )
    comparison = result.comparison
    probability = words.number(comparison.p_value, 2)
    tested = f"(χ² = {words.number(comparison.chi2)} for {comparison.residuals.size}, p = {probability})"
    if result.consistent:
        texts.append(f"What was attained is what the model predicts, to within the uncertainty of both {tested}.")
    else:
        texts.append(
            f"What was attained is not what the model predicts {tested}: nothing follows for poses and loads that were "
            "not measured."
        )
    return texts


def _figures(result: Verification) -> KeyFigures:
    return KeyFigures(
        (
            KeyFigure("Verdict", _VERDICTS[result.verdict]),
            KeyFigure(
                "Coverage factor", words.number(result.coverage.factor), "", f"{100 * result.coverage.level:.4g} %"
            ),
            KeyFigure("Risk", words.number(100.0 * result.risk, 2), "%", "of passing beyond a tolerance, at most"),
            KeyFigure("Model test", words.number(result.comparison.p_value, 2), "", "probability of larger deviations"),
        )
    )


def _subject(model: Model, check: CheckMeasurement, about: About) -> list[tuple[str, str]]:
    robot = model.chain.robot
    return [
        ("Laboratory", about.laboratory or _BLANK),
        ("Robot", f"{about.robot or robot.name} ({robot.kind})"),
        ("Serial number", about.serial_number or _BLANK),
        ("Load", about.load or _load(check)),
        ("Instrument", about.instrument or _BLANK),
        ("Environment", about.environment or _BLANK),
        ("Operator", about.operator or _BLANK),
        ("Date of measurement", about.date or _BLANK),
        ("Model", model.source),
        *([("Remarks", about.remarks)] if about.remarks else []),
    ]


def _load(check: CheckMeasurement) -> str:
    payload = check.points.payload
    if payload is None:
        return "wrenches as in the recordings"
    low, high = float(payload[:, 0].min()), float(payload[:, 0].max())
    return f"{words.given(low)} kg" if low == high else f"{words.given(low)} to {words.given(high)} kg"


def _table(result: Verification, model: Model) -> DataTable:
    columns = ["Target, axis", "Unit", "Measured error e", "u", "U", "Tolerance", "(|e| + U) / tolerance", "Result"]
    rows = []
    for number, target in enumerate(result.targets, start=1):
        rows += [_row(number, axis) for axis in target.axes]
    names = model.chain.robot.configuration
    places = "; ".join(
        f"target {number}: "
        + ", ".join(
            f"{name} {words.given(float(value))}" for name, value in zip(names, target.configuration, strict=True)
        )
        for number, target in enumerate(result.targets, start=1)
    )
    caption = (
        f"Errors of the attained pose (attained minus wanted). {places}."
        if len(result.targets) <= 6
        else ("Errors of the attained pose (attained minus wanted).")
    )
    return DataTable("results-table", caption, columns, rows, _shown("results.csv", columns, rows))


def _row(number: int, axis: AxisResult) -> list[str]:
    def micro(value: float | None) -> str:
        return "not measured" if value is None else words.number(1e6 * value)

    ratio = "–"
    if axis.tolerance is not None and axis.error is not None and axis.expanded is not None:
        ratio = words.number((abs(axis.error) + axis.expanded) / axis.tolerance)
    return [
        f"target {number}, {words.axis(axis.axis)}",
        words.micro_unit(axis.axis),
        micro(axis.error),
        micro(axis.uncertainty),
        micro(axis.expanded),
        "none" if axis.tolerance is None else words.number(1e6 * axis.tolerance),
        ratio,
        axis.conformity,
    ]


def _rule(result: Verification) -> str:
    return (
        f"Decision rule: {RULE}. A robot with an axis beyond its tolerance passes with a probability of at most "
        f"{words.number(100.0 * result.risk, 2)} %. U is the expanded uncertainty of the mean of an axis' readings, "
        f"k = {words.number(result.coverage.factor)} (JCGM 100:2008); it is that of the instrument as stated."
    )


def _files(files: Mapping[str, str]) -> DataTable:
    rows = [[name, digest] for name, digest in files.items()] or [["none", "–"]]
    columns = ["File", "SHA-256"]
    csv = _shown("files.csv", columns, rows)
    return DataTable("files-table", "The files that this certificate rests on.", columns, rows, csv)


def _shown(name: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> Download:
    """A table as it is shown; `verification.json` has the figures unrounded."""
    return Download(name, csv_text(pd.DataFrame(list(rows), columns=list(columns))))
