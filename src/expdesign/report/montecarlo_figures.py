"""Figures of the page of `expdesign montecarlo`: densities of the attained error, and agreement with the prediction."""

from typing import Any

import numpy as np
import pandas as pd

from expdesign.assurance.validation.repeated import Repeated
from expdesign.report import words
from expdesign.report.blocks import Figure
from expdesign.report.figures import chart, curve, level, points, whiskers

_PANELS = 3
"""Densities beside each other."""
_HALF_WIDTH = 4.0
"""Predicted standard deviations that a density is drawn to either side."""
_BINS = 60
"""Of a histogram."""

CAUSE_NAMES = {"duir": "measurement noise", "feir": "load errors", "total": "both"}
_SHADES = {"duir": "noise", "feir": "load", "total": "total"}


def density_figure(result: Repeated, target: int) -> Figure:
    """Densities of the attained error at a target, one panel for each axis that matters."""
    names = result.problem.loaded.robot.coordinates.deflection
    axes = [int(axis) for axis in np.flatnonzero(result.problem.targets.importance[target] > 0.0)]
    across = min(_PANELS, len(axes))
    rows = -(-len(axes) // across)
    grid = {"rows": rows, "columns": across, "pattern": "independent", "xgap": 0.15, "ygap": 0.3}
    layout: dict[str, Any] = {"showlegend": True, "barmode": "overlay", "grid": grid}
    data, frames = [], []
    for panel, axis in enumerate(axes):
        suffix = "" if panel == 0 else str(panel + 1)
        frame = _densities(result, target, axis)
        frames.append(frame.assign(axis=names[axis]))
        for cause in result.drawn:
            name = CAUSE_NAMES[cause]
            place: dict[str, Any] = {"xaxis": f"x{suffix}", "yaxis": f"y{suffix}", "legendgroup": cause}
            for label, column, look in (
                (name, cause, {"shape": "hvh"}),
                (f"{name}, predicted", f"{cause}_predicted", {"dash": "dot"}),
            ):
                x, y = frame["error"].to_numpy(), frame[column].to_numpy()
                trace = curve(label, x, y, _SHADES[cause], showlegend=panel == 0, **place)
                data.append(trace | {"line": trace["line"] | look})
        unit = words.micro_unit(names[axis])
        layout[f"xaxis{suffix}"] = {"title": {"text": f"{words.axis(names[axis])}, {unit}"}}
        layout[f"yaxis{suffix}"] = {
            "rangemode": "tozero",
            "title": {"text": "" if panel % across else f"density, 1/{unit}"},
        }
    return chart(
        f"densities-{target + 1}", f"Density of the attained error at target {target + 1}", data,
        "Steps are the repetitions, dotted lines the normal density with the predicted standard deviation. Where they "
        "coincide, the prediction holds.",
        f"One panel per axis that matters at target {target + 1}: histogram of the attained minus the wanted pose for "
        "noise alone, load errors alone and both. The table of standard deviations holds the comparison.",
        frame=pd.concat(frames, ignore_index=True), height=170 + 290 * rows, **layout,
    )  # fmt: skip


def agreement_figure(result: Repeated) -> Figure:
    """Simulated by predicted standard deviation of every axis that matters, with three standard errors."""
    names = result.problem.loaded.robot.coordinates.deflection
    places = np.argwhere(result.problem.targets.importance > 0.0).tolist()
    labels = [f"{words.axis(names[axis])}, target {target + 1}" for target, axis in places]
    data = []
    for offset, cause in enumerate(result.drawn):
        estimate, predicted = result.deviations[cause]
        ratio = [estimate.value[t, i] / predicted[t, i] for t, i in places]
        error = [3.0 * estimate.standard_error[t, i] / predicted[t, i] for t, i in places]
        places_across = np.arange(len(places)) + 0.18 * (offset - 1)
        look: dict[str, Any] = {"text": labels, "hovertemplate": "%{text}: %{y:.4f}<extra></extra>"}
        bars = whiskers(error, shade=_SHADES[cause])
        data.append(points(CAUSE_NAMES[cause], places_across, ratio, _SHADES[cause], error_y=bars, **look))
    return chart(
        "agreement-figure", "Agreement with the prediction", data,
        "Standard deviation in the simulation divided by the predicted one; bars are three standard errors. They cover "
        "one where the prediction holds.",
        "Points with error bars per axis and target; the table of standard deviations holds the same numbers.",
        x={"tickvals": np.arange(len(places)), "ticktext": labels, "showgrid": False},
        y={"title": {"text": "simulated / predicted σ"}, "zeroline": False}, levels=[level(1.0, "muted", dash="solid")],
        filename="agreement", showlegend=True,
    )  # fmt: skip


def _densities(result: Repeated, target: int, axis: int) -> pd.DataFrame:
    """Error (µm or µrad) and densities (per µm or µrad) of every cause, simulated and predicted."""
    largest = max(1e6 * result.deviations[cause][1][target, axis] for cause in result.drawn)
    edges = _HALF_WIDTH * largest * np.linspace(-1.0, 1.0, _BINS + 1)
    middle = (edges[1:] + edges[:-1]) / 2.0
    columns: dict[str, Any] = {"error": middle.round(6)}
    for cause in result.drawn:
        errors = 1e6 * result.causes[cause].errors[:, target, axis]
        counts = np.histogram(errors, edges)[0]
        columns[cause] = _short(counts / (len(errors) * np.diff(edges)))
        sigma = 1e6 * result.deviations[cause][1][target, axis]
        normal = np.exp(-0.5 * (middle / sigma) ** 2) / (np.sqrt(2.0 * np.pi) * sigma) if sigma > 0.0 else 0.0 * middle
        columns[f"{cause}_predicted"] = _short(normal)
    return pd.DataFrame(columns)


def _short(values: Any) -> list[float]:
    """Four significant digits, which is more than a figure shows."""
    return [float(f"{value:.3e}") for value in values]
