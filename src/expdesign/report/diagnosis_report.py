"""The page of `expdesign diagnose`: what is wrong, where, how sure that is, and how much better the model is now."""

from typing import Any

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.diagnosis.base_models import base_model
from expdesign.diagnosis.diagnose import Diagnosis
from expdesign.diagnosis.locate import LEVEL
from expdesign.files.csv_writer import csv_text
from expdesign.model_error.recorded import HiddenByRecordings
from expdesign.model_error.statement import AccuracyStatement
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
    Steps,
)
from expdesign.report.hidden_physics import recordings_section
from expdesign.report.law_figures import law_blocks
from expdesign.report.page import Page
from expdesign.report.remark_texts import sentences

MOST_POINTS = 2000
MOST_MODELS = 60
_VERDICTS = {
    "consistent": "The base model explains these recordings to within their noise: nothing is missing that they show.",
    "explained": "The base model does not explain these recordings; with the physics named below it does.",
    "modelled": "The base model does not explain these recordings, and no named physics does; laws drawn from the "
    "recordings, at the places named below, do.",
    "unexplained": "Something is missing that no physics in the library accounts for. It is located below, not named.",
}


def diagnosis_report(
    result: Diagnosis, hidden: HiddenByRecordings | None = None, stated: AccuracyStatement | None = None
) -> Page:
    """The report of a diagnosis, with the accuracy and what may still be hidden where targets were named."""
    sections = [
        Section("result", "Result", [Sentences(_conclusions(result)), _key_figures(result)]),
        Section(
            "errors",
            "Before and after" if _added(result) else "Errors",
            [SideBySide([_error_figure(result)], [_axis_figure(result)])],
        ),
        Section("where", "Where the mismatch is", _where(result)),
        Section("residuals", "Residuals", _residual_figures(result)),
    ]
    if result.findings:
        sections.insert(1, Section("physics", "What was left out", [_effects_table(result)]))
    if hidden is not None:
        sections.append(recordings_section(hidden, stated))
    laws = law_blocks(result)
    if laws:
        sections.insert(2 if result.findings else 1, Section("laws", "Laws at ports", laws))
    sections += [
        Section("considered", "What was considered", [_considered_table(result)]),
        Section("next", "Next steps", [_next_steps(result)]),
        Section("words", "Words", [Definitions(_WORDS)]),
    ]
    rows = len(result.recordings)
    page = Page(
        title=f"Diagnosis of {result.robot.name}",
        subtitle=f"{result.robot.kind}, {words.count(rows, 'row')}; recordings {result.recordings.source}",
        sections=tuple(sections),
    )
    return page


def _conclusions(result: Diagnosis) -> list[str]:
    texts = [_VERDICTS[result.verdict]]
    for finding in result.findings:
        text = f"{finding.sentence} Probability {words.number(finding.probability, 2)}."
        if finding.share is not None:
            text += f" {100.0 * finding.share:.0f} % of the refits on nine tenths of the rows name it."
        if finding.indistinguishable:
            others = ", ".join(name.replace("_", " ") for name in finding.indistinguishable)
            text += f" Confounded with it in these recordings: {others}."
        texts.append(text)
    if result.verdict != "consistent":
        texts.append(f"Way of working: {result.method.name}, because {result.method.reason}.")
        axes = ", ".join(words.axis(name) for name in result.location.axes)
        texts.append(f"The mismatch shows in {axes}; it {_phrase(result.location.region)}.")
    errors = result.errors
    if result.findings:
        texts.append(
            f"Recordings that were not fitted ({errors.how}) are predicted to {words.number(errors.test_after)} "
            f"standard deviations instead of {words.number(errors.test_before)}; 1 is the noise."
        )
    if result.stability is not None:
        stable = result.stability
        text = f"Of {stable.refits} refits, each without a tenth of the rows, {100.0 * stable.same:.0f} % name the same"
        texts.append(f"{text} (score tests on the model linearised).")
    if np.isfinite(errors.coverage):
        share = f"{100.0 * errors.coverage:.1f} % of the readings that were not fitted"
        texts.append(f"{share} lie within their predicted 95 % intervals.")
    texts += sentences(result.caveats)
    if not result.noise.known:
        texts.append("The recordings state no standard deviations, so that the verdict rests on held-out error.")
    return texts


def _phrase(region: str) -> str:
    return region if region.startswith("varies") else f"is {region}"


def _key_figures(result: Diagnosis) -> KeyFigures:
    errors, unit, note = result.errors, "standard deviations", "RMS; 1 is the noise"
    items = [
        KeyFigure("Verdict", result.verdict),
        KeyFigure("Held out, base model", words.number(errors.test_before), unit, note),
        KeyFigure("Models tried", str(len(result.search.tried))),
    ]
    if _added(result):
        items.insert(2, KeyFigure("Held out, now", words.number(errors.test_after), unit, note))
    return KeyFigures(items)


def _effects_table(result: Diagnosis) -> DataTable:
    rows, records = [], []
    for finding in result.findings:
        for name, (value, low, high) in finding.parameters.items():
            shown = words.parameter(name, value)
            low_shown, high_shown = (words.number(shown.factor * end) for end in (low, high))
            rows.append(
                [
                    finding.physics.replace("_", " "),
                    finding.component,
                    f"{shown.title} ({shown.unit})" if shown.unit else shown.title,
                    words.number(shown.factor * value),
                    f"{low_shown} to {high_shown}" if abs(high) < 1e299 else words.UNDETERMINED,
                    words.number(finding.probability, 2),
                ]
            )
            records.append(
                {
                    "physics": finding.physics,
                    "component": finding.component,
                    "variant": finding.variant,
                    "parameter": name,
                    "value": value,
                    "low": low,
                    "high": high,
                    "probability": finding.probability,
                }
            )
    return DataTable(
        "effects",
        "Physics added to the model, with 95 % intervals. The CSV is in SI units.",
        ["Physics", "Component", "Parameter", "Value", "95 % interval", "Probability"],
        rows,
        Download("effects.csv", csv_text(pd.DataFrame(records))),
    )


def _error_figure(result: Diagnosis) -> Figure:
    errors = result.errors
    labels = ["fitted rows", "held-out rows"]
    before, after = [errors.train_before, errors.test_before], [errors.train_after, errors.test_after]
    return _bars(
        result,
        "errors-figure",
        "Error on fitted and on held-out rows",
        labels,
        before,
        after,
        f"Root mean square of residuals in standard deviations; held out: {errors.how}. The line is the noise.",
    )


def _axis_figure(result: Diagnosis) -> Figure:
    names = [
        words.axis(result.recordings.components(result.robot.coordinates)[axis]) for axis in result.recordings.axes
    ]
    counts = result.search.sample.counts & ~result.model.outliers
    before = np.sqrt((result.base.residuals[counts] ** 2).mean(axis=0))
    after = np.sqrt((result.model.fit.residuals[counts] ** 2).mean(axis=0))
    caption = "Root mean square of the fitted residuals per axis, in standard deviations."
    return _bars(result, "axes-figure", "Error per axis", names, list(before), list(after), caption)


def _added(result: Diagnosis) -> bool:
    """Whether the model differs from the base model, so that there is a before and an after."""
    return bool(result.findings) or bool(result.model.outliers.any())


def _bars(
    result: Diagnosis, identifier: str, title: str, labels: list[str], before: Any, after: Any, caption: str
) -> Figure:
    data = [
        {"type": "bar", "name": "base model", "x": labels, "y": before, "marker": {"color": "var(--muted)"}},
        {"type": "bar", "name": "with the physics", "x": labels, "y": after, "marker": {"color": "var(--accent)"}},
    ][: 2 if _added(result) else 1]
    layout = {
        "barmode": "group",
        "yaxis": {"title": {"text": "RMS, in σ of the noise"}, "rangemode": "tozero"},
        "shapes": [_noise_line()],
        "showlegend": True,
    }
    frame = pd.DataFrame({"of": labels, "base_model": before, "with_physics": after}, dtype=object)
    return Figure(
        identifier,
        title,
        {"data": data, "layout": layout},
        caption,
        "Bars of the root mean square before and after; the CSV has the numbers.",
        Download(f"{identifier}.csv", csv_text(frame)),
        height=320,
        filename=identifier,
    )


def _noise_line() -> dict[str, Any]:
    line = {"color": "var(--text)", "dash": "dot", "width": 1}
    return {"type": "line", "xref": "paper", "x0": 0, "x1": 1, "y0": 1, "y1": 1, "line": line}


def _where(result: Diagnosis) -> list[Block]:
    location = result.location
    rows, records = [], []
    for kind, probes in (("part of the machine", location.components), ("dependence", location.patterns)):
        for probe in probes:
            rows.append(
                [
                    probe.name,
                    kind,
                    words.number(probe.explained, 4),
                    str(probe.dimension),
                    words.number(probe.p_value, 2),
                    "stands out" if probe.p_value < LEVEL else "",
                ]
            )
            records.append({"kind": kind, **vars(probe)})
    table = DataTable(
        "probes",
        "How much of χ² any cause in that place, or any straight line or parabola in that quantity, would explain. "
        "p is corrected for the number of tests in its group.",
        ["Where", "Kind", "Explains", "Directions", "p", ""],
        rows,
        Download("location.csv", csv_text(pd.DataFrame(records))),
        tall=True,
    )
    return [Paragraph("Tests of the base model's residuals, before any physics is named."), table]


def _residual_figures(result: Diagnosis) -> list[Block]:
    recordings, robot, sample = result.recordings, result.robot, result.search.sample
    step = max(1, len(recordings) // MOST_POINTS)
    blocks: list[Block] = [
        _scatter(result, "sequence", recordings.sequence[::step].astype(float), "sequence", step),
        *([_leg_figure(result)] if robot.actuators and base_model(robot, sample.reading).located_by_force else []),
    ]
    forces, moments = np.split(recordings.wrenches, [robot.coordinates.translations], axis=1)
    part, unit = (forces, "N") if forces.any() else (moments, "N·m")
    size = np.linalg.norm(part, axis=1)
    blocks.append(_scatter(result, "load", size[::step], f"size of the load, {unit}", step))
    coordinate = _most_informative_coordinate(result)
    poses = recordings.configurations[::step, robot.configuration.index(coordinate)]
    if np.ptp(poses) > 0.0:
        blocks.append(
            _scatter(result, "pose", poses, f"{coordinate}, the pose coordinate on which they depend most", step)
        )
    if recordings.time is not None:
        blocks.append(_scatter(result, "time", recordings.time[::step], "time, s", step))
    half = (len(blocks) + 1) // 2
    return [SideBySide(blocks[:half], blocks[half:])]


def _most_informative_coordinate(result: Diagnosis) -> str:
    """The pose coordinate on which the residuals of the base model depend most."""
    names = result.robot.configuration
    return next((probe.name for probe in result.location.patterns if probe.name in names), names[0])


def _scatter(result: Diagnosis, name: str, driver: FloatArray, label: str, step: int) -> Figure:
    """RMS over the axes of every row, before and after, against a quantity."""
    counts = (result.search.sample.counts & ~result.model.outliers)[::step]
    driver = driver[counts]
    before = np.sqrt((result.base.residuals**2).mean(axis=1))[::step][counts]
    after = np.sqrt((result.model.fit.residuals**2).mean(axis=1))[::step][counts]
    data = [
        {
            "type": "scatter", "mode": "markers", "name": label_of, "x": driver, "y": np.round(values, 4),
            "marker": {"color": colour, "size": 7, "symbol": symbol},
        }
        for label_of, values, colour, symbol in (
            ("base model", before, "var(--muted)", "circle-open"),
            ("with the physics", after, "var(--accent)", "circle"),
        )[: 2 if _added(result) else 1]
    ]  # fmt: skip
    layout = {
        "xaxis": {"title": {"text": label}},
        "yaxis": {"title": {"text": "RMS of the row, in σ"}, "rangemode": "tozero"},
        "shapes": [_noise_line()],
        "showlegend": True,
    }
    frame = pd.DataFrame({name: driver, "before": before, "after": after})
    return Figure(
        f"by-{name}",
        f"Residuals by {name}",
        {"data": data, "layout": layout},
        "Each point is one row of the recordings that was fitted. Outliers and rows that were held out are left out; "
        "the dotted line is the noise.",
        f"Scatter of the size of residuals against {label}, before and after.",
        Download(f"residuals-by-{name}.csv", csv_text(frame)),
        height=340,
        filename=f"residuals-by-{name}",
    )


def _leg_figure(result: Diagnosis) -> Figure:
    """Residuals as motions of the actuators."""
    names = result.robot.actuators
    motion, part = (
        ("motions of the joints", "joint") if result.robot.links is not None else ("length changes of the legs", "leg")
    )
    before, after = (_in_legs(result, residuals) for residuals in (result.base.residuals, result.model.fit.residuals))
    return _bars(
        result,
        "legs-figure",
        f"Residuals as {motion}",
        list(names),
        list(before),
        list(after),
        f"Least-squares projection of the residuals onto each {part} alone, in standard deviations of that projection.",
    )


def _in_legs(result: Diagnosis, residuals: FloatArray) -> FloatArray:
    """RMS over rows of the whitened residuals' component along the motion that each leg causes, shape (n_p,)."""
    recordings = result.recordings
    pose_map = result.robot.jacobians(recordings.configurations).pose[:, recordings.axes]
    directions = result.search.sample.whitening.apply(pose_map)
    norms = np.linalg.norm(directions, axis=1)
    along = np.einsum("nk,nkj->nj", residuals, directions) / np.where(norms > 0.0, norms, 1.0)
    rms: FloatArray = np.sqrt((along[result.search.sample.counts] ** 2).mean(axis=0))
    return rms


def _considered_table(result: Diagnosis) -> DataTable:
    entries = result.search.log.entries
    rows = []
    for entry in entries[:MOST_MODELS]:
        effects = entry["effects"]
        assert isinstance(effects, list)
        rows.append(
            [
                str(entry["step"]),
                "; ".join(effects).replace("_", " ") or "base model",
                _shown(entry["chi2"]),
                _shown(entry["penalised_misfit"]),
                "kept" if entry["kept"] else "not kept",
                str(entry["reason"]),
            ]
        )
    frame = pd.DataFrame([{**entry, "effects": "; ".join(entry["effects"])} for entry in entries])  # type: ignore[arg-type]
    part = f" The first {MOST_MODELS} of {len(entries)}; the CSV has all." if len(entries) > MOST_MODELS else ""
    return DataTable(
        "considered-table",
        "Models that were fitted in full, and why each was kept or not. The penalised misfit charges every effect for "
        "its parameters and for the number of places at which it was looked for." + part,
        ["Step", "Physics", "χ²", "Penalised misfit", "", "Reason"],
        rows,
        Download("considered.csv", csv_text(frame)) if entries else None,
        tall=True,
    )


def _shown(value: object) -> str:
    """A number of the log, or nothing where the entry concerns no single model."""
    return "" if value is None else words.number(float(str(value)), 5)


def _next_steps(result: Diagnosis) -> Steps:
    steps = [
        (
            f"Predict {'with the physics included' if _added(result) else 'deflections anywhere'}.",
            "expdesign predict model.yaml points.csv --out predicted.csv",
        ),
        (
            "Find commands that reach targets under load.",
            "expdesign compensate model.yaml targets.csv --out commands.csv",
        ),
    ]
    if result.rival is not None:
        steps.insert(0, ("Measure plan-next.csv: it separates the two remaining explanations.", ""))
    if result.verdict == "unexplained":
        steps.insert(0, ("Look at the place named above; record again with more loads and poses there.", ""))
    return Steps(steps)


_WORDS = [
    ("Base model", "One linear spring per actuator and nothing else."),
    ("Standard deviation", "Size of the noise of a reading; residuals divided by it scatter with RMS 1."),
    ("Held out", "Recordings that a model has not seen when it was fitted; what it says about them is a prediction."),
    (
        "Probability",
        "That this physics at this component is really there, given these recordings and the library of physics that "
        "was searched.",
    ),
]
