"""What `verify` returns and its page, the certificate: what is attained against prediction and tolerance, who signs."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from expdesign.assurance.acceptance.certificate import About, certificate_number
from expdesign.assurance.acceptance.check_measurement import CheckMeasurement
from expdesign.assurance.acceptance.verification import RULE, Verification, verification_record
from expdesign.chain.models.model_file import Model
from expdesign.estimation.compensation.arm_targets import base_as_drawn
from expdesign.probabilities import probability_text
from expdesign.report import words
from expdesign.report.blocks import (
    DataTable,
    Definitions,
    KeyFigure,
    KeyFigures,
    PageSection,
    Paragraph,
    Sentences,
    Shown,
    framed,
    number_of,
)
from expdesign.report.page import Page
from expdesign.report.result import PAGE, FolderResult
from expdesign.report.said import Said

_BLANK = "_" * 40
_RESTS = "The files that this certificate rests on, with their SHA-256."
_VERDICTS = {"no tolerance": "no decision"}
_MARKS = {"conforms": "✓", "does not conform": "✗"}
_TONES = {"pass": "good", "fail": "bad"}


_IN_BASE = (
    "The measured poses are taken as poses in O, whose rotation about joint 1 no reading of the model shows. If the "
    "identified instrument read them, give the frame `instrument` to `compensate` and to `verify`."
)


@dataclass(frozen=True, repr=False)
class VerificationResult(FolderResult):
    """A verified robot.

    Attributes:
        model: of the robot.
        check: what was measured.
        result: what it says.
        about: texts of the certificate.
        hashes: SHA-256 of every file, by its name.
    """

    FILES: ClassVar = {"verification.json": "record", **PAGE}
    model: Model
    check: CheckMeasurement
    result: Verification
    about: About
    hashes: dict[str, str]

    @property
    def chi2(self) -> float | None:
        """χ² of attained against predicted; None where it is not tested."""
        return self.result.statement.chi2

    @property
    def p_value(self) -> float | None:
        """Probability of a χ² as large as this if the model predicts what is attained; None where it is not tested."""
        return self.result.statement.p_value

    @property
    def said(self) -> Said:
        robot = self.model.chain.robot
        axes = tuple(robot.coordinates.deflection[axis] for axis in self.check.axes)
        record = verification_record(self.result, robot, axes, self.about, self.hashes)
        record |= {"frame": self.check.frame} if self.check.frame == "instrument" else {}
        record = {"certificate": certificate_number(record)} | record
        stated = ("remarks", "robot", "load")  # known from the model and the recordings otherwise
        empty = [name for name, text in self.about.model_dump().items() if not text and name not in stated]
        notes = [f"left to be filled in by hand: {', '.join(empty)}"] if empty else []
        if base_as_drawn(self.model, self.check.frame) and not self.result.consistent:
            notes.append(_IN_BASE)
        lines = [f"verdict: {self.result.verdict}", *statement(self.result)]
        return Said(f"verdict {self.result.verdict} for {robot.name}", lines, notes, lambda: record)

    @property
    def refused(self) -> bool:
        """Whether the robot fails."""
        return self.result.verdict == "fail"

    def page(self) -> Page:
        """The certificate, to be printed and signed."""
        result, number, robot = self.result, self.record["certificate"], self.model.chain.robot
        subject = [("Certificate", number), *_subject(self.model, self.check, self.about)]
        listed = list(self.hashes.items()) or [("none", "–")]
        table = _table(result, self.model, self.record["targets"])
        signature = (("Date", _BLANK), ("Name and signature", _BLANK))
        sections = (
            PageSection("statement", "Statement", (_figures(result), Sentences(statement(result)))),
            PageSection("subject", "Subject", (Definitions(subject),)),
            PageSection("results", "Results", (table, Paragraph(_rule(result)))),
            PageSection("files", "Files", (Paragraph(_RESTS), Definitions(listed))),
            PageSection("signature", "Signature", (Definitions(signature),)),
        )
        return Page(
            title=f"Certificate of verification: {self.about.robot or robot.name}",
            subtitle=f"Accuracy under load after compensation, {words.count(len(self.check), 'check measurement')}",
            sections=sections,
            footer=f"Certificate {number}, made by expdesign {version('expdesign')}",
        )


def statement(result: Verification) -> list[str]:
    """What is certified, in words."""
    axes = [axis for target in result.targets for axis in target.conformity[target.matters]]
    proven, beyond = axes.count("conforms"), axes.count("does not conform")
    counts = f"of {len(axes)} axes with a tolerance, {proven} conform, {beyond} do not conform, and "
    counts += f"{len(axes) - proven - beyond} are not proven to conform"
    texts = [
        {
            "pass": f"The robot passes: all {len(axes)} axes with a tolerance conform.",
            "fail": f"The robot fails: {counts}.",
            "not proven": f"Not proven: {counts}. No axis is proven to be beyond its tolerance.",
            "no tolerance": "No tolerance was stated, so that nothing is decided.",
        }[result.verdict]
    ]
    texts += _readings_needed(result)
    missed = sum(len(target.rows) == 0 for target in result.targets)
    if result.off_target:
        texts.append(
            "No check reading is at a target of the configuration: measure at commands for its targets (their poses "
            "and loads)."
        )
    elif missed:
        texts.append(
            f"{words.sentence(words.count(missed, 'target'))} of the configuration "
            f"{'was' if missed == 1 else 'were'} not measured."
        )
    attained = "The attained poses are those that the model predicts, to within the uncertainty of both"
    if result.statement.refuted:
        attained = "The attained poses are not those that the model predicts"
    elif result.statement.verdict == "too good":
        attained += f"; the stated standard deviations are about {result.statement.overstated:.3g} times too large"
    texts.append(f"{attained} ({result.statement.tested}).")
    if result.statement.refuted and result.statement.worst is not None:
        texts.append(result.statement.worst.sentence)
    if result.statement.refuted or result.model_refuted:
        why = "The model's own recordings refute it: nothing" if result.model_refuted else "Nothing"
        texts.append(f"{why} follows for poses and loads that were not measured.")
    return texts


def _readings_needed(result: Verification) -> list[str]:
    """How many readings prove conformity."""
    if not result.decided:
        return []
    count = result.readings_needed
    if result.verdict == "pass":
        return [f"{words.sentence(words.count(count or 0, 'independent reading'))} of every target proved it."]
    if count is None and result.verdict == "not proven":
        return [
            "How many readings would prove conformity cannot be said yet: of an axis the mean error is beyond the "
            "tolerance, though by less than its uncertainty, or its uncertainty is not known. Take more readings."
        ]
    if count is None:
        return ["No number of readings would prove conformity with the mean errors as they are."]
    readings = words.count(count, "independent reading")
    return [f"If the mean errors stay as they are, {readings} of every target would prove conformity."]


def _figures(result: Verification) -> KeyFigures:
    k, level = words.number(result.coverage.factor), f"{100 * result.coverage.level:.4g} %"
    items = [
        KeyFigure("Verdict", _VERDICTS.get(result.verdict, result.verdict), tone=_TONES.get(result.verdict, "")),
        KeyFigure("Coverage factor", k, "", level),
    ]
    if result.verdict == "pass":
        percent = words.number(100.0 * result.risk, 2)
        items.append(KeyFigure("Risk", percent, "%", "of passing beyond a tolerance, at most"))
    elif result.readings_needed is not None:
        items.append(
            KeyFigure("Readings needed", str(result.readings_needed), "", "of every target, to prove conformity")
        )
    p_value = result.statement.p_value
    tested = "none" if p_value is None else probability_text(p_value, 2)
    items.append(KeyFigure("Model test", tested, "", "probability of larger deviations"))
    return KeyFigures(items)


def _subject(model: Model, check: CheckMeasurement, about: About) -> list[tuple[str, str]]:
    robot = model.chain.robot
    return [
        ("Laboratory", about.laboratory or _BLANK),
        ("Robot", f"{about.robot or robot.name} ({robot.kind})"),
        ("Serial number", about.serial_number or _BLANK),
        ("Load", about.load or _load(check)),
        ("Weights (numbers, calibration)", about.weights or _BLANK),
        ("Instrument", about.instrument or _BLANK),
        ("Instrument (number, calibration)", about.instrument_number or _BLANK),
        ("Environment", about.environment or _BLANK),
        ("Operator", about.operator or _BLANK),
        ("Date of measurement", about.date or _BLANK),
        ("Model", model.source),
        *([("Frame of targets", "the instrument's, as the model has it")] if check.frame == "instrument" else []),
        *([("Remarks", about.remarks)] if about.remarks else []),
    ]


def _load(check: CheckMeasurement) -> str:
    payload = check.points.payload
    if payload is None:
        return "wrenches as in the recordings"

    def spread(column: int, factor: float) -> str:
        low, high = (factor * float(bound(payload[:, column])) for bound in (np.min, np.max))
        return words.given(low) if low == high else f"{words.given(low)} to {words.given(high)}"

    axes = zip("xyz", range(1, payload.shape[1]), strict=False)
    centre = ", ".join(f"{axis} {spread(column, 1e3)}" for axis, column in axes)
    return f"{spread(0, 1.0)} kg" + (f", centre of mass {centre} mm" if centre else "")


def _table(result: Verification, model: Model, stated: list[dict[str, Any]]) -> DataTable:
    """The axes of all targets, as the record has them (`stated`)."""
    frame = pd.DataFrame(
        [{"target": number, **axis} for number, target in enumerate(stated, start=1) for axis in target["axes"]]
    )

    def micro(column: str, missing: str = "not measured") -> Callable[[Any], str]:
        return lambda row: missing if pd.isna(getattr(row, column)) else number_of(column, 1e6)(row)

    shown: Shown = {
        "Target, axis": lambda row: f"target {row.target}, {words.axis(row.axis)}",
        "Unit": lambda row: words.micro_unit(row.axis),
        "Measured error e": micro("error"),
        "u": micro("standard_uncertainty"),
        "U": micro("expanded_uncertainty"),
        "Tolerance": micro("tolerance", "none"),
        "(|e| + U) / tolerance": _ratio,
        "Result": lambda row: f"{row.conformity} {_MARKS.get(row.conformity, '')}".rstrip(),
    }
    columns = [words.plan_column(name) for name in model.chain.robot.configuration]
    places = (
        f"target {number}: {', '.join(map(_coordinate, columns, target.configuration.tolist()))}"
        for number, target in enumerate(result.targets, start=1)
    )
    caption = "Errors of the attained pose (attained minus wanted)."
    caption += f" {words.sentence('; '.join(places))}." if len(result.targets) <= 6 else ""
    return framed("results-table", f"{caption} The CSV is in SI units.", frame, shown)


def _ratio(row: Any) -> str:
    ratio = (abs(row.error) + row.expanded_uncertainty) / row.tolerance if row.tolerance else np.nan
    return "–" if pd.isna(ratio) else words.number(float(ratio))


def _coordinate(column: words.Column, value: float) -> str:
    """A coordinate of a target; an angle in degrees too."""
    text = f"{column.title} {words.given(value * column.factor)} {column.unit}"
    return f"{text} ({words.given(round(math.degrees(value), 4) + 0.0)}°)" if column.unit == "mrad" and value else text


def _rule(result: Verification) -> str:
    return (
        f"Decision rule: {RULE}. A robot with an axis beyond its tolerance passes with a probability of at most "
        f"{words.number(100.0 * result.risk, 2)} %. U is the expanded uncertainty of the mean of an axis' readings, "
        f"k = {words.number(result.coverage.factor)} (JCGM 100:2008); it is that of the instrument as stated."
    )
