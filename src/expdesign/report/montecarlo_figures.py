"""Figures of the page of `expdesign montecarlo`: densities of the attained error, and agreement with the prediction."""

from typing import Any

import numpy as np
import pandas as pd

from expdesign.files.csv_writer import csv_text
from expdesign.report import words
from expdesign.report.blocks import Download, Figure
from expdesign.validation.repeated import Repeated

CAUSE_NAMES = {"duir": "measurement noise", "feir": "load errors", "total": "both"}
_COLOURS = {"duir": "var(--noise)", "feir": "var(--load)", "total": "var(--total)"}
_BINS = 60
_HALF = 4.0
"""Predicted standard deviations that a density is drawn to either side."""
_ACROSS = 3
"""Panels beside each other."""


def density_figure(result: Repeated, target: int) -> Figure:
    """Densities of the attained error at a target, one panel for each axis that matters."""
    names = result.problem.loaded.robot.coordinates.deflection
    axes = [int(axis) for axis in np.flatnonzero(result.problem.targets.importance[target] > 0.0)]
    rows = -(-len(axes) // _ACROSS)
    data: list[dict[str, Any]] = []
    layout: dict[str, Any] = {"showlegend": True, "barmode": "overlay"}
    frames = []
    for panel, axis in enumerate(axes):
        suffix = "" if panel == 0 else str(panel + 1)
        frame = _densities(result, target, axis)
        frames.append(frame.assign(axis=names[axis]))
        for cause in result.drawn:
            name = CAUSE_NAMES[cause]
            place = {"xaxis": f"x{suffix}", "yaxis": f"y{suffix}", "legendgroup": cause, "showlegend": panel == 0}
            line = {"color": _COLOURS[cause]}
            data += [
                {"type": "scatter", "mode": "lines", "name": name, "x": frame["error"], "y": frame[cause],
                 "line": line | {"width": 2, "shape": "hvh"}, **place},
                {"type": "scatter", "mode": "lines", "name": f"{name}, predicted", "x": frame["error"],
                 "y": frame[f"{cause}_predicted"], "line": line | {"width": 1.5, "dash": "dot"}, **place},
            ]  # fmt: skip
        across, row = panel % _ACROSS, panel // _ACROSS
        width, height = 1.0 / min(_ACROSS, len(axes)), 1.0 / rows
        title = f"{words.axis(names[axis])}, {words.micro_unit(names[axis])}"
        layout[f"xaxis{suffix}"] = {
            "domain": [across * width + 0.04 * (across > 0), (across + 1) * width - 0.02],
            "anchor": f"y{suffix}",
            "title": {"text": title},
        }
        layout[f"yaxis{suffix}"] = {
            "domain": [1.0 - (row + 1) * height + 0.13 * (rows > 1), 1.0 - row * height - 0.02],
            "anchor": f"x{suffix}",
            "rangemode": "tozero",
            "title": {"text": "density"} if across == 0 else {},
        }
    for entry in data:
        entry["x"], entry["y"] = entry["x"].to_numpy(), entry["y"].to_numpy()
    table = pd.concat(frames, ignore_index=True)
    return Figure(
        f"densities-{target + 1}",
        f"Density of the attained error at target {target + 1}",
        {"data": data, "layout": layout},
        "Steps are the repetitions, dotted lines the normal density with the predicted standard deviation. Where they "
        "coincide, the prediction holds.",
        f"One panel per axis that matters at target {target + 1}: histogram of the attained minus the wanted pose for "
        "noise alone, load errors alone and both. The table of standard deviations holds the comparison.",
        Download(f"densities-{target + 1}.csv", csv_text(table)),
        height=170 + 290 * rows,
        filename=f"densities-{target + 1}",
    )


def agreement_figure(result: Repeated) -> Figure:
    """Simulated by predicted standard deviation of every axis that matters, with three standard errors."""
    names = result.problem.loaded.robot.coordinates.deflection
    places = np.argwhere(result.problem.targets.importance > 0.0).tolist()
    labels = [f"{words.axis(names[axis])}, target {target + 1}" for target, axis in places]
    data = []
    for offset, cause in enumerate(result.drawn):
        estimate, predicted = result.deviation(cause)
        ratio = [estimate.value[t, i] / predicted[t, i] for t, i in places]
        error = [3.0 * estimate.standard_error[t, i] / predicted[t, i] for t, i in places]
        data.append(
            {
                "type": "scatter", "mode": "markers", "name": CAUSE_NAMES[cause],
                "x": np.arange(len(places)) + 0.18 * (offset - 1), "y": ratio, "text": labels,
                "error_y": {"type": "data", "array": error, "color": _COLOURS[cause]},
                "marker": {"color": _COLOURS[cause], "size": 8},
                "hovertemplate": "%{text}: %{y:.4f}<extra></extra>",
            }
        )  # fmt: skip
    layout = {
        "xaxis": {"tickvals": np.arange(len(places)), "ticktext": labels, "showgrid": False},
        "yaxis": {"title": {"text": "simulated / predicted σ"}, "zeroline": False},
        "shapes": [{"type": "line", "xref": "paper", "x0": 0, "x1": 1, "y0": 1, "y1": 1,
                    "line": {"color": "var(--muted)", "width": 1}}],
        "showlegend": True,
    }  # fmt: skip
    return Figure(
        "agreement-figure",
        "Agreement with the prediction",
        {"data": data, "layout": layout},
        "Standard deviation in the simulation divided by the predicted one; bars are three standard errors. They cover "
        "one where the prediction holds.",
        "Points with error bars per axis and target; the table of standard deviations holds the same numbers.",
        filename="agreement",
    )


def _densities(result: Repeated, target: int, axis: int) -> pd.DataFrame:
    """Error (µm or µrad) and densities (per µm or µrad) of every cause, simulated and predicted."""
    largest = max(1e6 * result.deviation(cause)[1][target, axis] for cause in result.drawn)
    centre = 1e6 * result.bias.value[target, axis] if result.plant != "explicit" else 0.0
    edges = centre + _HALF * largest * np.linspace(-1.0, 1.0, _BINS + 1)
    middle = (edges[1:] + edges[:-1]) / 2.0
    columns: dict[str, Any] = {"error": middle.round(6)}
    for cause in result.drawn:
        errors = 1e6 * result.causes[cause].errors[:, target, axis]
        counts = np.histogram(errors, edges)[0]
        columns[cause] = _short(counts / (len(errors) * np.diff(edges)))
        sigma = 1e6 * result.deviation(cause)[1][target, axis]
        normal = np.exp(-0.5 * (middle / sigma) ** 2) / (np.sqrt(2.0 * np.pi) * sigma) if sigma > 0.0 else 0.0 * middle
        columns[f"{cause}_predicted"] = _short(normal)
    return pd.DataFrame(columns)


def _short(values: Any) -> list[float]:
    """Four significant digits, which is more than a figure shows."""
    return [float(f"{value:.3e}") for value in values]
