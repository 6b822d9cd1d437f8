"""Stiffnesses, identified or beside the physics that a diagnosis found: frames, a table and a figure."""

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from expdesign.estimation.coverage import NORMAL_95
from expdesign.estimation.identify import Identification
from expdesign.estimation.intervals import Intervals
from expdesign.mechanics.robots.robot import Robot
from expdesign.report import words
from expdesign.report.blocks import DataTable, Figure, Shown, framed, number_of
from expdesign.report.figures import chart, points, whiskers

if TYPE_CHECKING:  # an identification need not wait for it
    from expdesign.diagnosis.result import Diagnosis

_HEADS = {"low": "Low", "high": "High", "springs_alone": "Springs alone", "robot_file": "Robot file"}
"""Headings by the columns that are stiffnesses."""


def stiffness_unit(robot: Robot) -> str:
    """N/m for actuators that change length, N·m/rad for those that turn."""
    return " or ".join(dict.fromkeys("N/m" if unit == "m" else "N·m/rad" for unit in robot.units))


def identified_stiffness(result: Identification) -> pd.DataFrame:
    """Stiffness with 95 % intervals and compliance of every actuator, and the robot file's stiffness (SI)."""
    interval, compliance = result.stiffness, result.compliance.estimate
    columns = {"stiffness": interval.estimate, "low": interval.low, "high": interval.high, "compliance": compliance}
    columns |= {"compliance_std": np.sqrt(np.diag(result.covariance)), "robot_file": result.robot.stiffness}
    return pd.DataFrame({"actuator": result.robot.actuators, **columns})


def added_physics(result: "Diagnosis") -> bool:
    """Whether the model has springs and, beside them, physics that explains the recordings."""
    return result.verdict in ("explained", "modelled") and bool(result.predictive.fit.chain.compliances)


def diagnosed_stiffness(result: "Diagnosis") -> pd.DataFrame:
    """Stiffnesses of the diagnosed model with 95 % intervals, and those of the base model (SI)."""
    fit, robot = result.known, result.robot
    part = slice(0, fit.chain.compliances)
    estimate = fit.values[part] * robot.compliance
    half = NORMAL_95 * np.sqrt(np.diag(fit.covariance)[part]) * robot.compliance
    interval = Intervals(estimate, estimate - half, estimate + half).inverse()
    with np.errstate(divide="ignore"):  # a compliance of 0 is a spring without end
        springs = 1.0 / (result.base.values[part] * robot.compliance)
    columns = {"stiffness": interval.estimate, "low": interval.low, "high": interval.high, "springs_alone": springs}
    return pd.DataFrame({"actuator": robot.actuators, **columns, "robot_file": robot.stiffness})


def stiffness_table(frame: pd.DataFrame, robot: Robot, about: str) -> DataTable:
    """One of these frames as a table; `about` goes on from *Stiffness in N/m* in its caption.

    Where the compliance may be 0, there is a least stiffness, and no estimate.
    """
    unit, inverse, factor = words.stiffness(stiffness_unit(robot))

    def estimate(row: Any) -> str:
        return number_of("stiffness", factor, 4)(row) if np.isfinite(row.high) else words.UNDETERMINED

    heads = {"stiffness": f"Stiffness ({unit})", **_HEADS}
    inverses = {"compliance": f"Compliance ({inverse})", "compliance_std": "Compliance σ"}
    cells = {
        (heads | inverses)[name]: number_of(name, factor if name in heads else 1.0 / factor, 4)
        for name in map(str, frame.columns[1:])
    }
    shown: Shown = {"Actuator": "actuator", **cells, heads["stiffness"]: estimate}
    return framed("stiffness-table", f"Stiffness in {unit} {about} The CSV is in SI units.", frame, shown)


def stiffness_figure(result: Identification) -> Figure:
    """Stiffness of every actuator that has an interval, beside the robot file's."""
    frame = identified_stiffness(result)
    unit, _, factor = words.stiffness(stiffness_unit(result.robot))
    known = frame[np.isfinite(frame[["stiffness", "low", "high"]]).all(axis=1)]
    names, file = known["actuator"].tolist(), factor * known["robot_file"].to_numpy()
    estimate, low, high = (factor * known[["stiffness", "low", "high"]].to_numpy()).T
    traces = [
        points("identified, 95 % interval", names, estimate, "accent", size=10,
               error_y=whiskers(high - estimate, estimate - low, "accent")),
        points("robot file", names, file, "muted", size=14, symbol="line-ew-open"),
    ]  # fmt: skip
    return chart(
        "stiffness-figure", "Stiffness of every actuator", traces,
        "Points are the identified stiffnesses, bars their 95 % intervals, dashes what the robot file says.",
        "Identified stiffness per actuator with intervals; the table below has the same numbers.",
        y=f"stiffness, {unit}", frame=frame, filename="stiffness", showlegend=True,
    )  # fmt: skip
