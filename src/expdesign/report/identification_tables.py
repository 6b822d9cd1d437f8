"""Figure and tables of the page of `expdesign identify`: stiffnesses, and what each measurement contributed."""

import numpy as np
import pandas as pd

from expdesign.arrays import IntArray
from expdesign.chain.recordings.recordings import Recordings
from expdesign.estimation.identify import Identification
from expdesign.probabilities import probability_text
from expdesign.report import words
from expdesign.report.blocks import DataTable, Figure, table_of
from expdesign.report.figures import chart, points, whiskers
from expdesign.report.identification_record import stiffness_unit

MOST_ROWS = 200
"""Rows that the table of measurements shows; of more the outliers and the largest leverages."""
MOST_DOWNLOADED = 10000
"""Rows beyond which the table's CSV holds what is shown, so that the page stays small."""


def stiffness_figure(result: Identification) -> Figure:
    """Stiffness of every actuator that has an interval, beside the robot file's."""
    interval = result.stiffness
    unit, _, factor = words.stiffness(stiffness_unit(result))
    index = np.flatnonzero(np.isfinite([interval.estimate, interval.high, interval.low]).all(axis=0))
    names = [result.robot.actuators[i] for i in index]
    estimate, low, high = (factor * values[index] for values in (interval.estimate, interval.low, interval.high))
    traces = [
        points("identified, 95 % interval", names, estimate, "accent", size=10,
               error_y=whiskers(high - estimate, estimate - low, "accent")),
        points("robot file", names, factor * result.robot.stiffness[index], "muted", size=14, symbol="line-ew-open"),
    ]  # fmt: skip
    return chart(
        "stiffness-figure", "Stiffness of every actuator", traces,
        "Points are the identified stiffnesses, bars their 95 % intervals, dashes what the robot file says.",
        "Identified stiffness per actuator with intervals; the table below has the same numbers.",
        y=f"stiffness, {unit}", frame=_stiffness_frame(result), filename="stiffness", showlegend=True,
    )  # fmt: skip


def _stiffness_frame(result: Identification) -> pd.DataFrame:
    """Stiffness and compliance of every actuator in SI units."""
    interval = result.stiffness
    deviation = np.sqrt(np.diag(result.covariance))
    return pd.DataFrame(
        {
            "actuator": result.robot.actuators,
            "stiffness": interval.estimate,
            "low": interval.low,
            "high": interval.high,
            "compliance": result.compliance.estimate,
            "compliance_std": deviation,
            "robot_file": result.robot.stiffness,
        }
    )


def stiffness_table(result: Identification) -> DataTable:
    """Stiffness and compliance of every actuator."""
    frame = _stiffness_frame(result)
    unit, inverse, factor = words.stiffness(stiffness_unit(result))
    factors = np.array([factor, factor, factor, 1.0 / factor, 1.0 / factor, factor])
    rows = [
        [str(row[0]), *(words.number(float(value), 4) for value in row[1:].astype(float) * factors)]
        for row in frame.to_numpy()
    ]
    caption = f"Stiffness in {unit} with 95 % intervals; compliance is its inverse. The CSV is in SI units."
    heads = ["Actuator", f"Stiffness ({unit})", "Low", "High", f"Compliance ({inverse})", "Compliance σ", "Robot file"]
    return table_of("stiffness-table", caption, heads, rows, frame)


def measurement_table(result: Identification, train: Recordings) -> DataTable:
    """Leverage, doubt and share of the information of every fitted row."""
    effect = result.influence
    best = effect.share.argmax(axis=1)
    frame = pd.DataFrame(
        {
            "sequence": train.sequence,
            "row": train.lines,
            "leverage": effect.leverage,
            "p_value": effect.p_value,
            "outlier": effect.outlier,
            "informs": np.array(result.robot.actuators)[best],
            "share": effect.share[np.arange(len(best)), best],
        }
    )
    shown = frame.iloc[_most_influential(result)]
    rows = [
        [str(sequence), str(row), words.number(leverage), probability_text(p), "outlier" if outlier else "", informs,
         f"{words.number(100.0 * share, 2)} %"]
        for sequence, row, leverage, p, outlier, informs, share in shown.itertuples(index=False, name=None)
    ]  # fmt: skip
    few = len(shown) < len(train)
    part = f" Shown are outliers and the largest leverages, {len(shown)} rows in all." if few else ""
    caption = (
        "Leverage is how much of the fit hangs on a row (they add up to the number of stiffnesses); p is the chance of "
        "a residual as large by noise alone; the share is of all information on that actuator's stiffness."
    )
    heads = ["Sequence", "Row", "Leverage", "p", "Flag", "Informs most", "Share"]
    saved = frame if len(frame) <= MOST_DOWNLOADED else shown
    return table_of("measurements", caption + part, heads, rows, saved, tall=True)


def _most_influential(result: Identification) -> IntArray:
    """Rows for the table: all, or the outliers and those with the largest leverage."""
    leverage = result.influence.leverage
    if len(leverage) <= MOST_ROWS:
        return np.arange(len(leverage))
    ranked = np.argsort(-(leverage + 1e9 * result.influence.outlier), kind="stable")
    return np.sort(ranked[:MOST_ROWS])
