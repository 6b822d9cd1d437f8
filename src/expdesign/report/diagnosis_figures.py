"""Figures of the page of `expdesign diagnose`: residuals before and after.

Laws in the report of a diagnosis: their curves, and where they may be.
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.diagnosis.base_models import base_model
from expdesign.diagnosis.findings import Finding
from expdesign.diagnosis.law_findings import curve_file, curves
from expdesign.diagnosis.result import Diagnosis
from expdesign.probabilities import probability_text
from expdesign.report import words
from expdesign.report.blocks import Block, DataTable, Figure, Shown, SideBySide, framed, number_of
from expdesign.report.diagnosis_texts import candidates, in_prose
from expdesign.report.figures import axis, band, bars, chart, curve, level, points

_CURVE_LINES = 6
"""Outputs of a law that its figure shows, the largest."""
_LISTED = 0.01
"""Probability from which a place of a law is listed."""
_POINTS = 3000
"""Of a figure; of more rows every second, third ... is drawn."""


def law_blocks(result: Diagnosis) -> list[Block]:
    """Table of places, where laws were looked for one by one, and curves; empty where no law was found."""
    places = [] if result.laws is None else [_places_table(result)]
    return [*places, *(law_figure(result, finding) for finding in curves(result.findings))]


def law_figure(result: Diagnosis, finding: Finding) -> Figure:
    """The curve of a law with its 95 % band, one line per output, over the input that tells most."""
    found = finding.curve
    assert found is not None
    varied, outputs = np.array(found.varied), np.array(found.output)
    ranges = {i: float(np.ptp(found.mean[varied == i])) for i in np.unique(varied)}
    telling = max(ranges, key=lambda i: ranges[i])
    names = [q.name(result.robot) for q in found.quantities]
    unit = found.quantities[telling].unit(result.robot)
    chosen = {name: (outputs == name) & (varied == telling) for name in dict.fromkeys(found.output)}
    largest = sorted(chosen, key=lambda name: -float(np.ptp(found.mean[chosen[name]])))
    traces = []
    for name in largest[:_CURVE_LINES]:
        rows = chosen[name]
        x = found.inputs[rows, telling]
        traces += [band(x, found.low[rows], found.high[rows]), curve(name, x, found.mean[rows])]
    file = curve_file(result.findings, finding) or "law.csv"
    others = "" if len(names) == 1 else " Its other inputs are held at their medians."
    return chart(
        file.removesuffix(".csv"),
        f"{finding.component.capitalize()}: {finding.variant}",
        traces,
        f"What was found, with its 95 % band, over the range that the recordings cover.{others}",
        f"Curve of a law at {finding.component} over {names[telling]} with its 95 % band.",
        x=f"{names[telling]}{', ' + unit if unit else ''}",
        y={"compliance": "compliance, m/N", "elongation": "elongation, m"}.get(found.meaning, "law, SI units"),
        frame=found.frame(list(finding.columns)),
        height=340,
        showlegend=len(chosen) > 1,
    )


def _places_table(result: Diagnosis) -> DataTable:
    caption = (
        "Where each law may be. The evidence is that of all laws that the place could hold, beside the other laws; "
        "places whose probabilities are close cannot be told apart by these recordings."
    )
    shown: Shown = {
        "Law": "law",
        "Where": "component",
        "Log evidence": number_of("log_evidence", digits=4),
        "Probability": lambda row: probability_text(row.probability, 2),
    }
    listed = [place for place in candidates(result) if place["probability"] >= _LISTED]
    columns = ["law", "component", "log_evidence", "probability"]
    return framed("places", caption, pd.DataFrame(listed, columns=columns), shown)


def added(result: Diagnosis) -> bool:
    """Whether the model differs from the base model, so that there is a before and an after."""
    return bool(result.findings)


def error_figure(result: Diagnosis) -> Figure:
    """Root mean square on fitted and on held-out rows."""
    errors, labels = result.errors, ["fitted rows", "held-out rows"]
    before, after = [errors.train_before, errors.test_before], [errors.train_after, errors.test_after]
    caption = f"Root mean square of residuals in standard deviations; held out: {errors.how}. The line is the noise."
    return _bars(result, "errors-figure", "Error on fitted and on held-out rows", labels, before, after, caption)


def axis_figure(result: Diagnosis) -> Figure:
    """Root mean square of every measured axis."""
    measured = result.recordings.components(result.robot.coordinates)
    names = [words.axis(measured[axis]) for axis in result.recordings.axes]
    counts = result.names.sample.counts
    before, after = (
        np.sqrt((residuals[counts] ** 2).mean(axis=0))
        for residuals in (result.base.residuals, result.model.fit.residuals)
    )
    caption = "Root mean square of the fitted residuals per axis, in standard deviations."
    return _bars(result, "axes-figure", "Error per axis", names, before, after, caption)


def _bars(
    result: Diagnosis,
    identifier: str,
    title: str,
    labels: Sequence[str],
    before: Sequence[float] | FloatArray,
    after: Sequence[float] | FloatArray,
    caption: str,
) -> Figure:
    """Bars of the root mean square before and, where the model differs, after."""
    traces = [bars("base model", labels, before, "muted"), bars("with the physics", labels, after, "accent")]
    frame = pd.DataFrame({"of": labels, "base_model": before, "with_physics": after}, dtype=object)
    return chart(
        identifier, title, traces[: 2 if added(result) else 1], caption,
        "Bars of the root mean square before and after; the CSV has the numbers.",
        y=axis("RMS, in σ of the noise", rangemode="tozero"), frame=frame, levels=[level(1.0)],
        height=320, barmode="group", showlegend=True,
    )  # fmt: skip


def residual_figures(result: Diagnosis) -> list[Block]:
    """Size of the residuals against order, load, pose and time, and as motions of the actuators."""
    recordings, robot, sample = result.recordings, result.robot, result.names.sample
    blocks: list[Block] = [_scatter(result, "sequence", recordings.sequence.astype(float), "sequence")]
    if robot.actuators and base_model(robot, sample.reading).elastic:
        blocks.append(_leg_figure(result))
    forces, moments = np.split(recordings.wrenches, [robot.coordinates.translations], axis=1)
    part, unit = (forces, "N") if forces.any() else (moments, "N·m")
    blocks.append(_scatter(result, "load", np.linalg.norm(part, axis=1), f"size of the load, {unit}"))
    coordinate = _most_informative_coordinate(result)
    poses = recordings.configurations[:, robot.configuration.index(coordinate)]
    if np.ptp(poses) > 0.0:
        label = f"{in_prose(coordinate)}, {coordinate.rsplit('_', 1)[1]} (most informative of the pose)"
        blocks.append(_scatter(result, "pose", poses, label))
    if recordings.time is not None:
        blocks.append(_scatter(result, "time", recordings.time, "time, s"))
    half = (len(blocks) + 1) // 2
    return [SideBySide(blocks[:half], blocks[half:])]


def _most_informative_coordinate(result: Diagnosis) -> str:
    """The pose coordinate on which the residuals of the base model depend most."""
    names = result.robot.configuration
    return next((probe.name for probe in result.location.patterns if probe.name in names), names[0])


def _scatter(result: Diagnosis, name: str, driver: FloatArray, label: str) -> Figure:
    """RMS over the axes of every row, before and after, against a quantity (one value per row)."""
    chosen = np.zeros(len(driver), dtype=bool)
    chosen[:: max(1, len(driver) // _POINTS)] = True
    chosen &= result.names.sample.counts
    before, after = (
        np.sqrt((residuals**2).mean(axis=1))[chosen]
        for residuals in (result.base.residuals, result.model.fit.residuals)
    )
    traces = [
        points("base model", driver[chosen], before.round(4), "muted", size=7, symbol="circle-open"),
        points("with the physics", driver[chosen], after.round(4), "accent", size=7),
    ]
    return chart(
        f"by-{name}", f"Residuals by {name}", traces[: 2 if added(result) else 1],
        "Each point is one row of the recordings that was fitted. Outliers and rows that were held out are left out; "
        "the dotted line is the noise.",
        f"Scatter of the size of residuals against {label}, before and after.",
        x=label, y=axis("RMS of the row, in σ", rangemode="tozero"), levels=[level(1.0)],
        frame=pd.DataFrame({name: driver[chosen], "before": before, "after": after}), height=340,
        filename=f"residuals-by-{name}", showlegend=True,
    )  # fmt: skip


def _leg_figure(result: Diagnosis) -> Figure:
    """Residuals as motions of the actuators."""
    arm = result.robot.jointed
    motion, part = ("motions of the joints", "joint") if arm else ("length changes of the legs", "leg")
    before, after = (_in_legs(result, residuals) for residuals in (result.base.residuals, result.model.fit.residuals))
    caption = (
        f"Least-squares projection of the residuals onto each {part} alone, in standard deviations of that projection."
    )
    return _bars(result, "legs-figure", f"Residuals as {motion}", result.robot.actuators, before, after, caption)


def _in_legs(result: Diagnosis, residuals: FloatArray) -> FloatArray:
    """RMS over rows of the whitened residuals' component along the motion that each leg causes, shape (n_p,)."""
    recordings = result.recordings
    pose_map = result.robot.jacobians(recordings.configurations).pose[:, recordings.axes]
    directions = result.names.sample.whitening.apply(pose_map)
    norms = np.linalg.norm(directions, axis=1)
    along = np.einsum("nk,nkj->nj", residuals, directions) / np.where(norms > 0.0, norms, 1.0)
    rms: FloatArray = np.sqrt((along[result.names.sample.counts] ** 2).mean(axis=0))
    return rms
