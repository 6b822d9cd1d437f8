"""What an identification found in numbers: `identification.json`, figures and tables of the page.

Whitened residuals stand against what varied in the recordings: order, pose, load; a selector chooses which.
"""

from typing import Any

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.recordings.references import sharing_rows
from expdesign.estimation.identify import Identification
from expdesign.estimation.intervals import Intervals
from expdesign.io.output import plain
from expdesign.probabilities import probability_text
from expdesign.report import words
from expdesign.report.arm_section import arm_record
from expdesign.report.blocks import (
    Block,
    DataTable,
    PageSection,
    Selector,
    Shown,
    choices,
    corrections_of,
    framed,
    number_of,
)
from expdesign.report.figures import chart, points
from expdesign.report.remark_texts import sentences
from expdesign.report.stiffness import stiffness_unit

_RECORDED_ROWS = 2000
"""Rows of recordings beyond which `identification.json` lists only those that are flagged."""
_DOWNLOADED_ROWS = 10000
"""Rows beyond which the CSV of measurements holds what is shown, so that the page stays small."""
_LISTED_ROWS = 200
"""Rows of the table of measurements; of more the outliers and the largest leverages."""
_LEVELS = 6
"""Decimals of a quantity's range to which its values are the same level."""
_FAST = 500
"""Points from which they are drawn by the graphics card."""
_POINTS = 3000
"""Of the figure; of more rows every second, third ... is drawn."""


def identification_record(result: Identification) -> dict[str, Any]:
    """The document; an interval without an end, and what does not exist, is null."""
    goodness, noise, robot = result.goodness, result.noise, result.robot
    lack = goodness.lack_of_fit
    record: dict[str, Any] = {
        "calibration": result.calibration,
        "stiffness": {} if result.calibration == "geometric" else _named(robot.actuators, result.stiffness),
        "unit": stiffness_unit(robot),
        **{name: getattr(goodness, name) for name in ("chi2", "dof", "p_value", "birge_ratio")},
        "statement": goodness.record,
        "covariance": result.covariance,
        "rank": result.fit.rank,
        "compliance": {} if result.calibration == "geometric" else _named(robot.actuators, result.compliance),
        "geometry": None if result.geometry is None else _named(result.geometry_names, result.geometry),
        "arm": arm_record(result),
        "lack_of_fit": None
        if lack is None
        else {"F": lack.ratio, "dof": lack.dof, "dof_pure_error": lack.pure_dof, "p_value": lack.p_value},
        "load_errors": None if result.loads is None else result.loads.record,
        "noise": {
            "origin": noise.origin,
            "levels": [{"of": group.name, "std": group.deviation, "dof": group.dof} for group in noise.groups],
        },
        "fit": {
            "rms": rms(result.fit.residuals),
            "test_rms": rms(result.test_residuals),
            "coverage_95": result.coverage,
        },
        "rows": {
            "total": len(result.recordings),
            "fitted": int(result.fitted.sum()),
            "test": int(result.recordings.test.sum()),
        },
        "prior_percent": None if result.prior is None else 100.0 * result.prior,
        "shared_reference": bool(sharing_rows(result.recordings.rows(result.fitted)).any()),
        "suspicions": sentences(result.suspicions),
        "measurements": _measurements(result),
    }
    record = plain(record)
    return record


def rms(residuals: FloatArray) -> float | None:
    """Root mean square of residuals in standard deviations; None where there are none."""
    return float(np.sqrt((residuals**2).mean())) if residuals.size else None


def _named(names: tuple[str, ...], intervals: Intervals) -> dict[str, Any]:
    return dict(zip(names, zip(intervals.estimate, intervals.low, intervals.high, strict=True), strict=True))


def measurement_frame(result: Identification) -> pd.DataFrame:
    """Leverage, outliers and the actuator that each fitted row informed most (none of a robot without actuators)."""
    effect, train = result.influence, result.recordings.rows(result.fitted)
    columns = {"leverage": effect.leverage, "p_value": effect.p_value, "outlier": effect.outlier}
    frame = pd.DataFrame({"sequence": train.sequence, "row": train.lines, **columns})
    if not result.robot.actuators:
        return frame.assign(informs=None, share=None)
    best = effect.share.argmax(axis=1)
    share = effect.share[np.arange(len(best)), best]
    return frame.assign(informs=np.array(result.robot.actuators)[best], share=share)


def _measurements(result: Identification) -> list[dict[str, Any]]:
    """The rows of the frame; of long recordings those that are flagged."""
    frame = measurement_frame(result)
    listed = frame if len(frame) <= _RECORDED_ROWS else frame[frame["outlier"]]
    return [dict(zip(map(str, listed.columns), row, strict=True)) for row in listed.astype(object).to_numpy().tolist()]


def geometry_section(result: Identification) -> PageSection:
    """Errors of joints and lengths with their intervals; needs an identification that has them."""
    interval = result.geometry
    assert interval is not None
    columns = {"estimate": interval.estimate, "low": interval.low, "high": interval.high}
    frame = pd.DataFrame({"parameter": result.geometry_names, **columns})
    caption = (
        "True minus nominal, in mm or mrad, with 95 % intervals. The model file carries them with their covariance: "
        "predictions and commands of `expdesign compensate` allow for them. The CSV is in SI units."
    )
    shown = {
        "Parameter": lambda row: str(row.parameter).replace("_", " "),
        **corrections_of("Error", "estimate"),
    }
    return PageSection("geometry", "Geometry", [framed("geometry-table", caption, frame, shown)])


def measurement_table(result: Identification) -> DataTable:
    """Leverage, doubt and share of the information of every fitted row."""
    frame = measurement_frame(result)
    listed = _most_influential(result)
    part = ""
    if len(listed) < len(frame):
        part = f" Shown are outliers and the largest leverages, {len(listed)} rows in all."
    caption = (
        "Leverage is how much of the fit depends on a row (they add up to the number of stiffnesses); p is the chance "
        "of a residual as large by noise alone; the share is of all information on that actuator's stiffness."
    )
    shown: Shown = {
        "Sequence": "sequence",
        "Row": "row",
        "Leverage": number_of("leverage"),
        "p": lambda row: probability_text(row.p_value),
        "Flag": lambda row: "outlier" if row.outlier else "",
        "Informs most": "informs",
        "Share": lambda row: f"{words.number(100.0 * row.share, 2)} %",
    }
    if len(frame) > _DOWNLOADED_ROWS:
        return framed("measurements", caption + part, frame.iloc[listed], shown, tall=True)
    return framed("measurements", caption + part, frame, shown, rows=listed.tolist(), tall=True)


def _most_influential(result: Identification) -> IntArray:
    """Rows for the table: all, or the outliers and those with the largest leverage."""
    leverage = result.influence.leverage
    if len(leverage) <= _LISTED_ROWS:
        return np.arange(len(leverage))
    ranked = np.argsort(-(leverage + 1e9 * result.influence.outlier), kind="stable")
    return np.sort(ranked[:_LISTED_ROWS])


SCRIPT = "residual_figure.js"
_SYMBOLS = ("circle", "square", "diamond", "triangle-up", "triangle-down", "cross")


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
    levels = {name: len(np.unique(np.round(values / span[name], _LEVELS))) for name, values in varying.items()}
    return dict(sorted(varying.items(), key=lambda item: -levels[item[0]]))


def residuals(result: Identification, train: Recordings) -> tuple[list[Block], dict[str, Any]]:
    """Whitened residuals against what varied most (the order where nothing did), and the data of the selector."""
    drawn = slice(None, None, max(1, len(train) // _POINTS))
    over = {name: values[drawn] for name, values in varied(result, train).items()}
    components = result.recordings.components(result.robot.coordinates)
    names = [words.axis(components[axis]) for axis in train.axes]
    values = np.round(result.fit.residuals[drawn], 4).T
    sequence = train.sequence[drawn]
    frame = pd.DataFrame({"sequence": sequence, "row": train.lines[drawn], **over})
    frame = frame.assign(**{f"{name}_in_std": column for name, column in zip(names, values, strict=True)})
    against = [_against(name, column) for name, column in over.items()]
    against.append({"title": "order of recording (sequence)", "values": sequence})
    kind = "scattergl" if len(train) > _FAST else "scatter"
    traces = [
        points(name, against[0]["values"], column, f"series-{place + 1}", symbol=_SYMBOLS[place], type=kind)
        for place, (name, column) in enumerate(zip(names, values, strict=True))
    ]
    figure = chart(
        "residuals", "Residuals against what varied", traces,
        "Measured minus fitted, divided by the standard deviation. Noise alone scatters about zero, mostly within ±2, "
        "without a pattern, whatever it is drawn against.",
        "Scatter of whitened residuals against the chosen coordinate, one series of points per measured axis.",
        x=against[0]["title"], y="residual, standard deviations", frame=frame, showlegend=True,
    )  # fmt: skip
    selector = Selector("residuals-over", "Against", choices(str(one["title"]) for one in against), step=True)
    return [selector, figure], {"residuals": against}


def _against(name: str, values: FloatArray) -> dict[str, Any]:
    """A coordinate as the figure shows it: title and values."""
    column = words.plan_column(name)
    return {"title": column.heading, "values": [float(f"{value * column.factor:.6g}") for value in values]}
