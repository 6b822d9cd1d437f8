"""A calibrated arm: what `expdesign identify` says of it, its tables, and its part of `identification.json`."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

from expdesign.chain.effects.instrument.frame import FrameWander
from expdesign.chain.effects.joints.geometry import CalibratedGeometryError
from expdesign.coordinates import SPATIAL
from expdesign.estimation.accuracy import Errors
from expdesign.estimation.arm import ArmCalibration
from expdesign.estimation.arm_outcome import Corrected, attached_frames, corrections, origins
from expdesign.estimation.coverage import NORMAL_95
from expdesign.estimation.identify import Identification
from expdesign.report import words
from expdesign.report.blocks import DataTable, PageSection, Sentences, Shown, corrections_of, framed


def arm_sections(result: Identification) -> list[PageSection]:
    """Accuracy before and after, corrected parameters, origins of the joints and frames."""
    found = result.arm
    assert found is not None
    sections = [PageSection("accuracy", "Accuracy before and after", [accuracy_table(found)])]
    listed = corrections(found, result.geometry)
    if listed:
        tables = [_geometry_table(listed), _origin_table(found)]
        sections.append(PageSection("geometry", "Geometry", [Sentences([_CORRECTIONS, _FILES]), *tables]))
    frames = _frame_table(found)
    return [*sections, *([] if frames is None else [PageSection("frames", "Tool and base frames", [frames])])]


def arm_sentences(result: Identification) -> list[str]:
    """What an arm's calibration found, beside its accuracy: parameters, sizes of their errors, and what was asked."""
    found = result.arm
    if found is None:
        return []
    lines = [*_told_apart(corrections(found, result.geometry)), *_levels(found), *_further(found)]
    return [f"{words.sentence(line)}." for line in lines]


def _levels(found: ArmCalibration) -> list[str]:
    """Standard deviations of the groups of errors that the rows ask for, beside those with which arms are made."""
    parts = [
        f"{level.name} held at the drawing"
        if not level.count
        else f"{level.name} {_level(level.size, level.unit)} (prior {_level(level.made, level.unit)}; "
        f"{level.determined:.1f} of {level.count} determined)"
        for level in found.levels
    ]
    return [f"size of the errors by group, estimated: {', '.join(parts)}"] if parts else []


def _level(size: float, unit: str) -> str:
    return f"{words.number(100.0 * size, 2)} %" if unit == "relative" else words.size(size, unit)


def _further(found: ArmCalibration) -> list[str]:
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


def _told_apart(listed: list[Corrected]) -> list[str]:
    """How many parameters of the geometry are told apart; nothing without geometry."""
    if not listed:
        return []
    told = sum(each.status == "told apart" for each in listed)
    held = sum(each.status == "held" for each in listed)
    others = sum(each.status == "stands in others" for each in listed)
    faint = len(listed) - told - others - held
    return [
        f"{told} of {len(listed)} parameters of the geometry told apart; {others} cannot be told from others, which "
        "represent them"
        + (f"; {faint} hardly {'shows and stays' if faint == 1 else 'show and stay'} near the drawing" if faint else "")
        + (f"; {held} {'is' if held == 1 else 'are'} held at the drawing" if held else "")
    ]


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


def accuracy_table(found: ArmCalibration) -> DataTable:
    """Lengths of the errors of every kind of row and of reading, before and after."""
    frame = pd.DataFrame(
        [
            {"of": kind, "which": which, "when": when, **_figures(errors)}
            for (which, kind), pair in found.accuracy.items()
            for when, errors in (("before", pair.before), ("after", pair.after))
        ]
    )

    caption = (
        "Distance between measured and predicted position, and angle between measured and predicted orientation (ISO "
        "9283 calls it accuracy, for one command). Before: the robot as its file has it, with instrument and markers "
        "fitted to it. Left-out folds are predicted by a fit to the others, linearised. The CSV is in m and rad."
    )

    def figure(name: str) -> Callable[[Any], str]:
        return lambda row: words.number(_in(row.of == "orientation")[1] * getattr(row, name))

    shown: dict[str, str | Callable[[Any], str]] = {
        "Error of": lambda row: f"{row.of}, {_in(row.of == 'orientation')[0]}",  # distances and gauges are lengths
        "Rows": lambda row: f"{row.which} ({row.rows})",
        "": "when",
    }
    for head, name in (("Mean", "mean"), ("RMS", "rms"), ("Maximum", "max"), ("95 %", "p95")):
        shown[head] = figure(name)
    return framed("accuracy", caption, frame, shown)


def _in(angle: bool) -> tuple[str, float]:
    """Unit in which an angle or a length is shown, and its factor."""
    return ("°", 180.0 / np.pi) if angle else ("mm", 1e3)


_CORRECTIONS = (
    "Corrections are true minus nominal: a joint's frame moves along x, y, z and turns about x, y, z of its own axes "
    "(those of its origin in the URDF, at coordinate zero); a zero adds to the commanded coordinate."
)
_FILES = (
    "`robot.urdf` has the corrected origins, and links `identified_…` where instrument and markers are; the model file "
    "carries the same with its covariance. What a URDF has no place for (springs, further physics) is in the model "
    "file alone."
)


def _geometry_table(listed: list[Corrected]) -> DataTable:
    frame = pd.DataFrame([vars(each) for each in listed])
    shown: Shown = {
        "Parameter": "label",
        **corrections_of("Correction", "value"),
        "Unit": lambda row: "mm" if row.unit == "m" else "mrad",
        "Status": lambda row: str(row.note or row.status),
    }
    caption = "Corrections with 95 % intervals. The CSV is in SI units."
    return framed("geometry-table", caption, frame, shown, tall=len(listed) > 40)


def _origin_table(found: ArmCalibration) -> DataTable:
    frame = pd.DataFrame(
        [
            [joint, which, *pose]
            for joint, (nominal, corrected) in origins(found).items()
            for which, pose in (("nominal", nominal), ("corrected", corrected))
        ],
        columns=["joint", "origin", *SPATIAL.pose],
    )
    names = zip(SPATIAL.pose, ("x, mm", "y, mm", "z, mm", "roll, °", "pitch, °", "yaw, °"), strict=True)

    def cell(name: str) -> Callable[[Any], str]:
        angle = name.endswith("_rad")
        return lambda row: words.fixed(_in(angle)[1] * getattr(row, name), 4 if angle else 3)

    shown: Shown = {"Joint": "joint", "": "origin", **{heading: cell(name) for name, heading in names}}
    return framed("origins", "Origins of the joints as in the URDF.", frame, shown)


def _frame_table(found: ArmCalibration) -> DataTable | None:
    chain = found.fit.chain
    part = slice(chain.compliances, chain.base)
    parameters = chain.parameters[part]
    if not parameters:
        return None
    columns: dict[str, Any] = {"of": found.labels[part], "parameter": [one.name for one in parameters]}
    columns |= {"estimate": found.fit.values[part], "std": np.sqrt(np.diag(found.fit.covariance))[part]}

    def scaled(row: Any) -> tuple[str, float]:
        return _in(row.parameter.endswith("_rad"))

    caption = (
        "The instrument's pose in the base frame, and the markers on the tip. They include whatever the geometry "
        "cannot be told apart from. The base frame is that of joint 1 as built."
    )
    shown: Shown = {
        "Of": "of",
        "Estimate": lambda row: words.fixed(scaled(row)[1] * row.estimate, 4),
        "± 95 %": lambda row: words.number(NORMAL_95 * scaled(row)[1] * row.std, 2),
        "Unit": lambda row: scaled(row)[0],
    }
    return framed("frames", caption, pd.DataFrame(columns), shown)
