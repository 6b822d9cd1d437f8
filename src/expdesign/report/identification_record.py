"""`identification.json` (file-formats.md, identification.json): what the identification found, as one document."""

from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.recordings.references import sharing_rows
from expdesign.estimation.identify import Identification
from expdesign.estimation.intervals import Intervals
from expdesign.mechanics.robots.robot import Robot
from expdesign.report.arm_section import arm_record
from expdesign.report.remark_texts import sentences

MOST_ROWS = 2000
"""Files with more rows list only those that are flagged."""


def identification_record(result: Identification) -> dict[str, Any]:
    """The document; an interval without an end, and what does not exist, is null."""
    goodness, noise, robot = result.goodness, result.noise, result.robot
    lack = goodness.lack_of_fit
    return {
        "calibration": result.calibration,
        "stiffness": {} if result.calibration == "geometric" else _named(robot.actuators, result.stiffness),
        "unit": stiffness_unit(result),
        "chi2": goodness.chi2,
        "dof": goodness.dof,
        "p_value": goodness.p_value,
        "birge_ratio": goodness.birge_ratio,
        "statement": goodness.record,
        "covariance": result.covariance.tolist(),
        "rank": result.fit.rank,
        "compliance": {} if result.calibration == "geometric" else _named(robot.actuators, result.compliance),
        "geometry": None if result.geometry is None else _named(result.geometry_names, result.geometry),
        "arm": arm_record(result),
        "lack_of_fit": None
        if lack is None
        else {"F": lack.ratio, "dof": lack.dof, "dof_pure_error": lack.pure_dof, "p_value": lack.p_value},
        "noise": {
            "origin": noise.origin,
            "levels": [{"of": group.name, "std": group.deviation, "dof": group.dof} for group in noise.groups],
        },
        "fit": {
            "rms": rms(result.fit.residuals),
            "test_rms": rms(result.test_residuals),
            "coverage_95": result.coverage if np.isfinite(result.coverage) else None,
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


def stiffness_unit(result: Identification) -> str:
    """N/m for actuators that change length, N·m/rad for those that turn."""
    return unit_of_stiffness(result.robot)


def unit_of_stiffness(robot: Robot) -> str:
    """N/m for actuators that change length, N*m/rad for those that turn."""
    if robot.coordinates.pose == robot.configuration:
        return "N/m"
    units = ("N*m/rad" if name.endswith("_rad") else "N/m" for name in robot.configuration)
    return " or ".join(dict.fromkeys(units))


def rms(residuals: FloatArray) -> float | None:
    """Root mean square of residuals in standard deviations; None where there are none."""
    return float(np.sqrt((residuals**2).mean())) if residuals.size else None


def _named(names: tuple[str, ...], intervals: Intervals) -> dict[str, list[float | None]]:
    columns = zip(intervals.estimate, intervals.low, intervals.high, strict=True)
    return {
        name: [float(value) if np.isfinite(value) else None for value in row]
        for name, row in zip(names, columns, strict=True)
    }


def _measurements(result: Identification) -> list[dict[str, Any]]:
    """Leverage, outliers and the actuator that each fitted row informed most."""
    effect = result.influence
    train = result.recordings.rows(result.fitted)
    rows = np.arange(len(train)) if len(train) <= MOST_ROWS else np.flatnonzero(effect.outlier)
    best = effect.share.argmax(axis=1) if result.robot.actuators else None
    return [
        {
            "sequence": int(train.sequence[row]),
            "row": int(train.lines[row]),
            "leverage": float(effect.leverage[row]),
            "p_value": float(effect.p_value[row]),
            "outlier": bool(effect.outlier[row]),
            "informs": result.robot.actuators[best[row]] if best is not None else None,
            "share": float(effect.share[row, best[row]]) if best is not None else None,
        }
        for row in rows
    ]
