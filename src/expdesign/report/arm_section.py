"""A calibrated arm on the page of `expdesign identify`, on the console and in `identification.json`."""

from typing import Any

import numpy as np
import pandas as pd

from expdesign.chain.effects.instrument.frame import FrameWander
from expdesign.chain.effects.joints.geometry import CalibratedGeometryError
from expdesign.estimation.accuracy import Errors
from expdesign.estimation.arm import ArmCalibration
from expdesign.estimation.arm_outcome import Corrected, attached_frames, corrections, origins
from expdesign.estimation.coverage import NORMAL_95
from expdesign.estimation.identify import Identification
from expdesign.io.output import csv_text
from expdesign.report import words
from expdesign.report.blocks import DataTable, Download, PageSection, Sentences

_NAMES = ("mean", "rms", "most", "percentile")
_HEADINGS = ("mean", "RMS", "maximum", "95 %")


def arm_sections(result: Identification) -> list[PageSection]:
    """Accuracy before and after, corrected parameters, origins of the joints and frames."""
    found = result.arm
    assert found is not None
    levels = levels_line(found)
    said = [] if levels is None else [Sentences([f"{words.sentence(levels)}."])]
    sections = [PageSection("accuracy", "Accuracy before and after", [_accuracy_table(found), *said])]
    further = [f"{words.sentence(line)}." for line in further_lines(found)]
    sections += [PageSection("further", "Beside geometry and compliances", [Sentences(further)])] if further else []
    listed = corrections(found, result.geometry)
    if listed:
        blocks = [Sentences(_geometry_texts(listed)), _geometry_table(listed), _origin_table(found)]
        sections.append(PageSection("geometry", "Geometry", blocks))
    frames = _frame_table(result, found)
    return [*sections, *([] if frames is None else [PageSection("frames", "Tool and base frames", [frames])])]


def levels_line(found: ArmCalibration) -> str | None:
    """Standard deviations of the groups of errors that the rows ask for, beside those with which arms are made."""
    parts = [
        f"{level.name} held at the drawing"
        if not level.count
        else f"{level.name} {_level(level.size, level.unit)} (made to {_level(level.made, level.unit)}; "
        f"{level.determined:.1f} of {level.count} determined)"
        for level in found.levels
    ]
    return f"size of the errors by group, estimated: {', '.join(parts)}" if parts else None


def _level(size: float, unit: str) -> str:
    return f"{100.0 * size:.2g} %" if unit == "relative" else words.size(size, unit)


def accuracy_lines(found: ArmCalibration) -> list[str]:
    """A line for every kind of row and of reading."""
    lines = []
    for (rows, kind), pair in found.accuracy.items():
        unit, factor = _unit(kind)
        parts = [
            f"{heading} {words.number(factor * getattr(pair.before, name))} → "
            f"{words.number(factor * getattr(pair.after, name))}"
            for name, heading in zip(_NAMES, _HEADINGS, strict=True)
        ]
        lines.append(f"{kind} of {pair.after.rows} rows ({rows}), before → after: {', '.join(parts)} {unit}")
    return lines


def further_lines(found: ArmCalibration) -> list[str]:
    """What was identified on request, a line for every parameter that the rows tell apart, with its 95 % interval."""
    chain, fit = found.fit.chain, found.fit
    deviations, lines = np.sqrt(np.diag(fit.covariance)), []
    for effect, part in zip(chain.effects, chain.slices, strict=True):
        if isinstance(effect, CalibratedGeometryError):
            continue
        if isinstance(effect, FrameWander):
            terms = {p.name: (float(v), 0.0, 0.0) for p, v in zip(effect.parameters, fit.values[part], strict=True)}
            lines.append(effect.sentence(terms).rstrip("."))
            continue
        told = [index for index in range(part.start, part.stop) if found.told_apart[index]]
        for index in told:
            value, spread = fit.values[index], NORMAL_95 * deviations[index]
            name = chain.parameters[index].name
            lines.append(
                f"{effect.component}, {name}: {value:.4g} (95 %: {value - spread:.4g} to {value + spread:.4g})"
            )
        if not told:
            lines.append(f"{effect.component}, {effect.declared.left_out}: the rows do not show it")
    return lines


def geometry_line(result: Identification) -> str | None:
    """How many parameters of the geometry are told apart; None without geometry."""
    found = result.arm
    listed = corrections(found, result.geometry) if found is not None else []
    if not listed:
        return None
    told = sum(each.status == "told apart" for each in listed)
    held = sum(each.status == "held" for each in listed)
    others = sum(each.status == "stands in others" for each in listed)
    return (
        f"{told} of {len(listed)} parameters of the geometry told apart; {others} cannot be told from others, which "
        f"stand for them, {len(listed) - told - others - held} hardly show and stay near the drawing"
        + (f", {held} are held there" if held else "")
    )


def arm_record(result: Identification) -> dict[str, Any] | None:
    """The key `arm` of `identification.json`."""
    found = result.arm
    if found is None:
        return None
    train = result.recordings.rows(result.fitted)
    return {
        "stated_noise": None
        if found.stated is None
        else {"chi2": found.stated[0], "dof": found.stated[1], "p_value": found.stated[2]},
        "accuracy": [
            {"rows": rows, "of": kind, "before": _figures(pair.before), "after": _figures(pair.after)}
            for (rows, kind), pair in found.accuracy.items()
        ],
        "groups": [vars(level) for level in found.levels],
        "parameters": [
            {
                "name": each.name, "of": each.label, "unit": each.unit,
                "correction": [each.value, each.low, each.high], "status": each.status, "note": each.note,
            }
            for each in corrections(found, result.geometry)
        ],
        "origins": {
            name: {"nominal": nominal, "corrected": corrected}
            for name, (nominal, corrected) in origins(found).items()
        }
        if result.geometry is not None
        else {},
        "frames": {
            frame.name: {"link": frame.link, "pose": frame.pose} for frame in attached_frames(found, train)
        },
    }  # fmt: skip


def _figures(errors: Errors) -> dict[str, float | int]:
    return {
        "rows": errors.rows, "mean": errors.mean, "rms": errors.rms, "max": errors.most, "p95": errors.percentile
    }  # fmt: skip


def _unit(kind: str) -> tuple[str, float]:
    return ("°", 180.0 / np.pi) if kind == "orientation" else ("mm", 1e3)  # distances and gauges are lengths


def _accuracy_table(found: ArmCalibration) -> DataTable:
    rows, frame = [], []
    for (which, kind), pair in found.accuracy.items():
        unit, factor = _unit(kind)
        for when, errors in (("before", pair.before), ("after", pair.after)):
            figures = [factor * float(getattr(errors, name)) for name in _NAMES]
            rows.append([f"{kind}, {unit}", f"{which} ({errors.rows})", when, *(words.number(x) for x in figures)])
            frame.append({"of": kind, "rows": which, "when": when, **_figures(errors)})
    caption = (
        "Distance between measured and predicted position, and angle between measured and predicted orientation (ISO "
        "9283 calls it accuracy, for one command). Before: the robot as its file has it, with instrument and markers "
        "fitted to it. Left-out folds are predicted by a fit to the others, linearised. The CSV is in m and rad."
    )
    csv = csv_text(pd.DataFrame(frame))
    return DataTable("accuracy-table", caption, ["Of", "Rows", "", "Mean", "RMS", "Maximum", "95 %"], rows,
                     Download("accuracy.csv", csv))  # fmt: skip


def _geometry_texts(listed: list[Corrected]) -> list[str]:
    told = [each for each in listed if each.status == "told apart"]
    return [
        f"{len(told)} of {len(listed)} parameters are told apart. Corrections are true minus nominal: a joint's frame "
        "moves along x, y, z and turns about x, y, z of its own axes (those of its origin in the URDF, at coordinate "
        "zero); a zero adds to the commanded coordinate.",
        "`robot.urdf` has the corrected origins, and links `identified_…` where instrument and markers are; the model "
        "file carries the same with its covariance.",
    ]


def _geometry_table(listed: list[Corrected]) -> DataTable:
    rows = [
        [each.label, *words.fitted(1e3 * each.value, 1e3 * each.low, 1e3 * each.high),
         "mm" if each.unit == "m" else "mrad", each.note or each.status]
        for each in listed
    ]  # fmt: skip
    frame = pd.DataFrame([vars(each) for each in listed])
    return DataTable(
        "geometry-table",
        "Corrections with 95 % intervals. The CSV is in SI units.",
        ["Parameter", "Correction", "Low", "High", "Unit", "Told apart"],
        rows,
        Download("geometry.csv", csv_text(frame)),
        tall=len(rows) > 40,
    )


def _origin_table(found: ArmCalibration) -> DataTable:
    rows = []
    for name, (nominal, corrected) in origins(found).items():
        for which, pose in (("nominal", nominal), ("corrected", corrected)):
            rows.append(
                [
                    name,
                    which,
                    *(words.fixed(1e3 * x, 3) for x in pose[:3]),
                    *(words.fixed(float(np.degrees(x)), 4) for x in pose[3:]),
                ]
            )
    columns = ["Joint", "", "x, mm", "y, mm", "z, mm", "roll, °", "pitch, °", "yaw, °"]
    return DataTable("origins-table", "Origins of the joints as in the URDF.", columns, rows)


def _frame_table(result: Identification, found: ArmCalibration) -> DataTable | None:
    chain = found.fit.chain
    parameters = chain.parameters[chain.compliances : chain.base]
    if not parameters:
        return None
    deviation = np.sqrt(np.diag(found.fit.covariance))[chain.compliances : chain.base]
    values = found.fit.values[chain.compliances : chain.base]
    rows = []
    for label, parameter, value, spread in zip(
        found.labels[chain.compliances : chain.base], parameters, values, deviation, strict=True
    ):
        factor, unit = (180.0 / np.pi, "°") if parameter.name.endswith("_rad") else (1e3, "mm")
        rows.append([label, words.fixed(factor * value, 4), words.number(NORMAL_95 * factor * spread, 2), unit])
    caption = (
        "The instrument's pose in the base frame, and the markers on the tip. What the geometry cannot be told from is "
        "in them: the base frame is that of joint 1 as it is."
    )
    return DataTable("frames-table", caption, ["Of", "Estimate", "± 95 %", "Unit"], rows)
