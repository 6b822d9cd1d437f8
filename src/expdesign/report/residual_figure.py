"""Whitened residuals against what varied in the recordings: order, pose, load; a selector chooses which."""

from typing import Any

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.chain.recordings.recordings import Recordings
from expdesign.estimation.identify import Identification
from expdesign.report import words
from expdesign.report.blocks import Block, Option, Selector
from expdesign.report.figures import chart, points

SCRIPT = "residual_figure.js"
MOST_POINTS = 3000
"""Points of the figure; of more rows every second, third ... is drawn."""
_FAST = 500
"""Rows from which points are drawn by the graphics card."""
_SYMBOLS = ("circle", "square", "diamond", "triangle-up", "triangle-down", "cross")
_DECIMALS = 6


def varied(result: Identification, train: Recordings) -> dict[str, FloatArray]:
    """Coordinates of pose and load that differ between rows, by their columns, what varies most first.

    Variation is counted in levels, the distinct values of a coordinate; among equals the earlier column comes first.
    Wrenches are given where no payload is known.
    """
    robot = result.robot
    columns = {name: train.configurations[:, i] for i, name in enumerate(robot.configuration)}
    if train.payload is not None:
        names = ("mass_kg", *robot.coordinates.centre_of_mass)
        columns |= {name: train.payload[:, i] for i, name in enumerate(names[: train.payload.shape[1]])}
    else:
        columns |= {name: train.wrenches[:, i] for i, name in enumerate(robot.coordinates.wrench)}
    span = {name: float(np.ptp(values)) for name, values in columns.items()}
    varying = {
        name: values for name, values in columns.items() if span[name] > 1e-9 * max(1e-3, float(np.abs(values).max()))
    }
    levels = {name: len(np.unique(np.round(values / span[name], _DECIMALS))) for name, values in varying.items()}
    return dict(sorted(varying.items(), key=lambda item: -levels[item[0]]))


def residual_blocks(result: Identification, train: Recordings) -> list[Block]:
    """The selector and the figure, which shows the coordinate that varies most; the order where none does."""
    step = max(1, len(train) // MOST_POINTS)
    choices = _choices(result, train)
    first = choices[0]
    names = result.recordings.components(result.robot.coordinates)
    kind = "scattergl" if len(train) > _FAST else "scatter"
    traces = [
        points(
            words.axis(names[axis]), first["values"], np.round(result.fit.residuals[::step, column], 4),
            f"series-{column + 1}", symbol=_SYMBOLS[column], type=kind,
        )
        for column, axis in enumerate(train.axes)
    ]  # fmt: skip
    figure = chart(
        "residuals", "Residuals against what varied", traces,
        "Measured minus fitted, divided by the standard deviation. Noise alone scatters about zero, mostly within ±2, "
        "without a pattern, whatever it is drawn against.",
        "Scatter of whitened residuals against the chosen coordinate, one series of points per measured axis.",
        x=first["title"], y="residual, standard deviations", frame=_frame(result, train), showlegend=True,
    )  # fmt: skip
    options = [Option(str(index), str(one["title"]), index == 0) for index, one in enumerate(choices)]
    return [Selector("residuals-over", "Against", options, step=True), figure]


def residual_data(result: Identification, train: Recordings) -> dict[str, Any]:
    """What the script of the selector needs."""
    return {"residuals": _choices(result, train)}


def _choices(result: Identification, train: Recordings) -> list[dict[str, Any]]:
    step = max(1, len(train) // MOST_POINTS)
    found: list[dict[str, Any]] = []
    for name, values in varied(result, train).items():
        column = words.plan_column(name)
        title = f"{column.title}, {column.unit}" if column.unit else column.title
        found.append({"title": title, "values": [float(f"{value * column.factor:.6g}") for value in values[::step]]})
    return [*found, {"title": "order of recording (sequence)", "values": train.sequence[::step]}]


def _frame(result: Identification, train: Recordings) -> pd.DataFrame:
    """Whitened residuals of the rows that are drawn, with what varied (SI)."""
    step = max(1, len(train) // MOST_POINTS)
    frame = pd.DataFrame({"sequence": train.sequence[::step], "row": train.lines[::step]})
    for name, values in varied(result, train).items():
        frame[name] = values[::step]
    names = result.recordings.components(result.robot.coordinates)
    for column, axis in enumerate(train.axes):
        frame[f"{words.axis(names[axis])}_in_std"] = np.round(result.fit.residuals[::step, column], 4)
    return frame
