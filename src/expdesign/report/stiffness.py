"""Stiffnesses beside the physics that a diagnosis found, as a table and in lines."""

import numpy as np
import pandas as pd

from expdesign.diagnosis.result import Diagnosis
from expdesign.estimation.intervals import Intervals
from expdesign.report import words
from expdesign.report.blocks import DataTable, table_of
from expdesign.report.identification_record import unit_of_stiffness

_NORMAL_95 = 1.959963984540054
"""Standard deviations of a normal 95 % interval to each side."""


def added_physics(result: Diagnosis) -> bool:
    """Whether the model has springs and, beside them, physics that explains the recordings."""
    return result.verdict in ("explained", "modelled") and bool(result.predictive.fit.chain.compliances)


def stiffness_frame(result: Diagnosis) -> pd.DataFrame:
    """Stiffnesses of the diagnosed model with 95 % intervals, and those of the base model (SI)."""
    fit, robot = result.known, result.robot
    part = slice(0, fit.chain.compliances)
    estimate = fit.values[part] * robot.compliance
    half = _NORMAL_95 * np.sqrt(np.diag(fit.covariance)[part]) * robot.compliance
    interval = Intervals(estimate, estimate - half, estimate + half).inverse()
    springs = 1.0 / (result.base.values[part] * robot.compliance)
    columns = {"stiffness": interval.estimate, "low": interval.low, "high": interval.high, "springs_alone": springs}
    return pd.DataFrame({"actuator": robot.actuators, **columns, "robot_file": robot.stiffness})


def stiffness_table(result: Diagnosis) -> DataTable:
    """The same as a table."""
    frame = stiffness_frame(result)
    unit, _, factor = words.stiffness(unit_of_stiffness(result.robot))
    rows = [
        [name, *(words.number(factor * value, 4) for value in values)]
        for name, *values in frame.itertuples(index=False, name=None)
    ]
    heads = ["Actuator", f"Stiffness ({unit})", "Low", "High", "Springs alone", "Robot file"]
    caption = f"Stiffness in {unit} with this physics in the model, with 95 % intervals; beside it the base model's."
    return table_of("stiffness-table", f"{caption} The CSV is in SI units.", heads, rows, frame)


def stiffness_lines(result: Diagnosis) -> list[str]:
    """The same for a terminal."""
    units = ["N/m" if unit == "m" else "N*m/rad" for unit in result.robot.units]
    frame = stiffness_frame(result)[["actuator", "stiffness", "low", "high"]]
    return [
        f"{name}: {value:.4g} {unit} (95 %: {low:.4g} to {high:.4g})" if np.isfinite([low, high]).all() and low > 0.0
        else f"{name}: not determined by these recordings"
        for unit, (name, value, low, high) in zip(units, frame.itertuples(index=False, name=None), strict=True)
    ]  # fmt: skip
