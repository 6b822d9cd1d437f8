"""The page of `expdesign identify`: stiffness, how well it is known, and how well the model fits the recordings."""

import shlex

import numpy as np
import pandas as pd

from expdesign.arrays import IntArray
from expdesign.files.csv_writer import csv_text
from expdesign.identification.goodness import REFUTED
from expdesign.identification.identify import Identification
from expdesign.recordings.recordings import Recordings
from expdesign.report import words
from expdesign.report.blocks import (
    DataTable,
    Definitions,
    Download,
    Figure,
    KeyFigure,
    KeyFigures,
    Section,
    Sentences,
    Steps,
)
from expdesign.report.geometry_section import geometry_section
from expdesign.report.identification_record import rms, stiffness_unit
from expdesign.report.page import Page
from expdesign.report.remark_texts import sentences
from expdesign.report.residual_figure import SCRIPT, residual_blocks, residual_data

DOUBTFUL = REFUTED
"""Probability below which a test speaks against the model."""
_TITLES = {"elastostatic": "Stiffness", "geometric": "Geometry", "both": "Geometry and stiffness"}
MOST_ROWS = 200
MOST_DOWNLOADED = 10000
"""Rows beyond which the table's CSV holds what is shown, so that the page stays small."""


def identification_report(result: Identification, robot_file: str = "", configuration: str = "") -> Page:
    """The report of an identification.

    Args:
        result: what was found.
        robot_file: path of the robot's file, for the commands; empty where it is not known.
        configuration: path of the run configuration whose targets count; empty where it is not known.
    """
    train = result.recordings.rows(result.fitted)
    robot = result.robot
    stiffness = bool(robot.actuators) and result.calibration != "geometric"
    sections = (
        Section("result", "Result", [Sentences(_conclusions(result)), _key_figures(result)]),
        *([_stiffness_section(result)] if stiffness else []),
        *([geometry_section(result)] if result.geometry is not None else []),
        Section("fit", "How well the model fits", [Definitions(_tests(result)), *residual_blocks(result, train)]),
        *([_measurement_section(result, train)] if robot.actuators else []),
        Section("next", "Next steps", [_next_steps(result, robot_file, configuration)]),
        Section("words", "Words", [Definitions(_WORDS)]),
    )
    page = Page(
        title=f"{_TITLES[result.calibration]} of {robot.name}",
        subtitle=(
            f"{robot.kind}, {words.count(len(train), 'fitted measurement')} of "
            f"{words.count(len(result.recordings), 'row')}; recordings {result.recordings.source}"
        ),
        sections=sections,
        data=residual_data(result, train),
        scripts=(SCRIPT,),
    )
    return page


def _stiffness_section(result: Identification) -> Section:
    return Section("stiffness", "Stiffness", [_stiffness_figure(result), _stiffness_table(result)])


def _measurement_section(result: Identification, train: Recordings) -> Section:
    return Section("measurements", "What each measurement contributed", [_measurement_table(result, train)])


def _least_certain(result: Identification) -> str:
    """What is known worst; of a robot without actuators, that there is nothing to identify."""
    interval, names = result.stiffness, result.robot.actuators
    unit, _, factor = words.stiffness(stiffness_unit(result))
    if not names:
        return (
            f"A {result.robot.kind} has no actuators whose stiffness could be identified: its base model does not "
            "deflect at all, and what follows says whether the recordings show that it does. `expdesign diagnose` "
            "finds what yields."
        )
    if result.calibration == "geometric":
        return "The geometry was identified from rows without load; stiffness is what the robot file says."
    relative = np.sqrt(np.diag(result.covariance)) / np.abs(result.compliance.estimate)
    worst = int(np.argmax(relative))
    return (
        f"The least certain stiffness is that of {names[worst]}: {words.number(factor * interval.estimate[worst])} "
        f"{unit}, known to {words.number(100.0 * relative[worst], 2)} % (one standard deviation)."
    )


def _conclusions(result: Identification) -> list[str]:
    texts = [_least_certain(result)]
    goodness = result.goodness
    if goodness.p_value is not None:
        texts.append(
            "The model explains the recordings to within their stated noise."
            if goodness.p_value >= DOUBTFUL
            else "The model does not explain the recordings to within their stated noise: physics is left out, or "
            f"the noise is larger than stated. Intervals are {words.number(goodness.birge_ratio)} times (the Birge "
            "ratio) as wide as the stated noise alone would make them, as is every standard deviation that the model "
            "predicts."
        )
    else:
        texts.append(
            f"The recordings state no standard deviations; the noise was estimated from their {_source(result)}, and "
            "the intervals allow for that."
        )
    lack = goodness.lack_of_fit
    if lack is not None and lack.p_value < DOUBTFUL:
        texts.append("Replicates agree with each other better than with the model: physics is left out.")
    outliers = np.flatnonzero(result.influence.outlier)
    if outliers.size:
        train = result.recordings.rows(result.fitted)
        listed = ", ".join(str(train.sequence[row]) for row in outliers[:10])
        looking = words.sentence(words.count(outliers.size, "row looks", "rows look"))
        texts.append(f"{looking} like outliers (sequence {listed}).")
    held_out = rms(result.test_residuals)
    if held_out is not None:
        texts.append(f"The rows held out for testing are predicted to {words.number(held_out)} standard deviations.")
    return texts + sentences(result.suspicions)


def _source(result: Identification) -> str:
    return "replicates" if result.noise.origin == "replicates" else "residuals"


def _key_figures(result: Identification) -> KeyFigures:
    train, held_out = rms(result.fit.residuals), rms(result.test_residuals)
    relative = np.sqrt(np.diag(result.covariance)) / np.abs(result.compliance.estimate)
    items = [KeyFigure("Residuals", words.number(train or 0.0), "standard deviations", "RMS; 1 is the noise")]
    if relative.size:
        items += [
            KeyFigure("Worst stiffness", words.number(100.0 * float(relative.max()), 2), "%", "one standard deviation"),
            KeyFigure("Rank", f"{result.fit.rank} of {len(result.fit.values)}", "", "stiffnesses determined"),
        ]
    if held_out is not None:
        items.append(KeyFigure("Held-out rows", words.number(held_out), "standard deviations", "RMS"))
    return KeyFigures(items)


def _stiffness_figure(result: Identification) -> Figure:
    interval = result.stiffness
    unit, _, factor = words.stiffness(stiffness_unit(result))
    shown = np.isfinite(interval.estimate) & np.isfinite(interval.high) & np.isfinite(interval.low)
    index = np.flatnonzero(shown)
    names = [result.robot.actuators[i] for i in index]
    data = [
        {
            "type": "scatter", "mode": "markers", "name": "identified, 95 % interval", "x": names,
            "y": factor * interval.estimate[index],
            "marker": {"color": "var(--accent)", "size": 10},
            "error_y": {
                "type": "data", "symmetric": False, "color": "var(--accent)",
                "array": factor * (interval.high - interval.estimate)[index],
                "arrayminus": factor * (interval.estimate - interval.low)[index],
            },
        },
        {
            "type": "scatter", "mode": "markers", "name": "robot file", "x": names,
            "y": factor * result.robot.stiffness[index],
            "marker": {"color": "var(--muted)", "size": 14, "symbol": "line-ew-open"},
        },
    ]  # fmt: skip
    layout = {"yaxis": {"title": {"text": f"stiffness, {unit}"}}, "showlegend": True}
    return Figure(
        "stiffness-figure",
        "Stiffness of every actuator",
        {"data": data, "layout": layout},
        "Points are the identified stiffnesses, bars their 95 % intervals, dashes what the robot file says.",
        "Identified stiffness per actuator with intervals; the table below has the same numbers.",
        Download("stiffness.csv", csv_text(_stiffness_frame(result))),
        filename="stiffness",
    )


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


def _stiffness_table(result: Identification) -> DataTable:
    frame = _stiffness_frame(result)
    unit, inverse, factor = words.stiffness(stiffness_unit(result))
    factors = np.array([factor, factor, factor, 1.0 / factor, 1.0 / factor, factor])
    rows = [
        [str(row[0]), *(words.number(float(value), 4) for value in row[1:].astype(float) * factors)]
        for row in frame.to_numpy()
    ]
    return DataTable(
        "stiffness-table",
        f"Stiffness in {unit} with 95 % intervals; compliance is its inverse. The CSV is in SI units.",
        ["Actuator", f"Stiffness ({unit})", "Low", "High", f"Compliance ({inverse})", "Compliance σ", "Robot file"],
        rows,
        Download("stiffness.csv", csv_text(frame)),
    )


def _tests(result: Identification) -> list[tuple[str, str]]:
    goodness, noise = result.goodness, result.noise
    items: list[tuple[str, str]] = []
    if goodness.chi2 is not None and goodness.p_value is not None:
        items.append(
            (
                "χ² test",
                f"{words.number(goodness.chi2, 4)} for {goodness.dof} degrees of freedom, p = "
                f"{words.number(goodness.p_value)} (doubtful below {DOUBTFUL:g})",
            )
        )
    else:
        items.append(("χ² test", "none: the noise level was estimated from these recordings"))
    lack = goodness.lack_of_fit
    items.append(
        (
            "Lack of fit",
            "none: there are no replicates"
            if lack is None
            else f"F = {words.number(lack.ratio)} with {lack.dof} and {lack.pure_dof} degrees of freedom, p = "
            f"{words.number(lack.p_value)}",
        )
    )
    for group in noise.groups:
        unit = "µm" if group.name == "translations" else "µrad"
        items.append(
            (
                f"Noise of the {group.name}",
                f"{words.number(1e6 * group.deviation)} {unit}, from the {_source(result)} with "
                f"{words.number(group.dof)} degrees of freedom",
            )
        )
    if result.prior is not None:
        items.append(("Prior", f"the robot file's compliances, known to {words.number(100.0 * result.prior)} %"))
    return items


def _measurement_table(result: Identification, train: Recordings) -> DataTable:
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
    shown = _most_influential(result)
    rows = [
        [
            str(frame["sequence"].iloc[row]),
            str(frame["row"].iloc[row]),
            words.number(effect.leverage[row]),
            words.number(effect.p_value[row]),
            "outlier" if effect.outlier[row] else "",
            frame["informs"].iloc[row],
            f"{words.number(100.0 * effect.share[row, best[row]], 2)} %",
        ]
        for row in shown
    ]
    part = (
        "" if len(shown) == len(train) else f" Shown are outliers and the largest leverages, {len(shown)} rows in all."
    )
    return DataTable(
        "measurements",
        "Leverage is how much of the fit hangs on a row (they add up to the number of stiffnesses); p is the chance of "
        "a residual as large by noise alone; the share is of all information on that actuator's stiffness." + part,
        ["Sequence", "Row", "Leverage", "p", "Flag", "Informs most", "Share"],
        rows,
        Download("measurements.csv", csv_text(frame if len(frame) <= MOST_DOWNLOADED else frame.iloc[shown])),
        tall=True,
    )


def _most_influential(result: Identification) -> IntArray:
    """Rows for the table: all, or the outliers and those with the largest leverage."""
    leverage = result.influence.leverage
    if len(leverage) <= MOST_ROWS:
        return np.arange(len(leverage))
    ranked = np.argsort(-(leverage + 1e9 * result.influence.outlier), kind="stable")
    return np.sort(ranked[:MOST_ROWS])


def _next_steps(result: Identification, robot_file: str, configuration: str) -> Steps:
    recordings = shlex.quote(result.recordings.source)
    robot, config = shlex.quote(robot_file or "ROBOT.yaml"), shlex.quote(configuration or "CONFIG.yaml")
    return Steps(
        [
            (
                "Predict deflections anywhere (model.yaml lies beside this page).",
                "expdesign predict model.yaml points.csv --out predicted.csv",
            ),
            (
                "Find commands that reach targets under load.",
                "expdesign compensate model.yaml targets.csv --out commands.csv",
            ),
            (
                "Measure compensated poses, and certify what is attained.",
                f"expdesign verify model.yaml check.csv --config {config} --out verified",
            ),
            (
                "If the model does not fit, find out why.",
                f"expdesign diagnose {robot} {recordings} --out diagnosed",
            ),
            (
                "If the accuracy is not enough, measure on.",
                f"expdesign next {config} {recordings} --out plan-next.csv",
            ),
        ]
    )


_WORDS = [
    ("Stiffness", "Force in an actuator per change of its length; the base model is one spring per actuator."),
    (
        "95 % interval",
        "Covers the true value in 95 of 100 repetitions of the experiment, if the model holds. A stiffness' interval "
        "is the inverse of its compliance's, and so is not symmetric.",
    ),
    ("Standard deviation (σ)", "Size of the noise: two thirds of the errors are smaller."),
    ("Replicates", "Rows with the same command under the same load; their scatter is noise and nothing else."),
]
