"""`identification.json` (file-formats.md, identification.json): what the identification found, as one document."""

from typing import Any

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.chain.recordings.references import sharing_rows
from expdesign.estimation.identify import Identification
from expdesign.estimation.intervals import Intervals
from expdesign.report.arm_section import arm_record
from expdesign.report.remark_texts import sentences
from expdesign.report.stiffness import stiffness_unit

MOST_ROWS = 2000
"""Files with more rows list only those that are flagged."""


def identification_record(result: Identification) -> dict[str, Any]:
    """The document; an interval without an end, and what does not exist, is null."""
    goodness, noise, robot = result.goodness, result.noise, result.robot
    lack = goodness.lack_of_fit
    return {
        "calibration": result.calibration,
        "stiffness": {} if result.calibration == "geometric" else _named(robot.actuators, result.stiffness),
        "unit": stiffness_unit(robot),
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


def rms(residuals: FloatArray) -> float | None:
    """Root mean square of residuals in standard deviations; None where there are none."""
    return float(np.sqrt((residuals**2).mean())) if residuals.size else None


def _named(names: tuple[str, ...], intervals: Intervals) -> dict[str, list[float | None]]:
    columns = zip(intervals.estimate, intervals.low, intervals.high, strict=True)
    return {
        name: [float(value) if np.isfinite(value) else None for value in row]
        for name, row in zip(names, columns, strict=True)
    }


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
    listed = frame if len(frame) <= MOST_ROWS else frame[frame["outlier"]]
    return [dict(zip(map(str, listed.columns), row, strict=True)) for row in listed.astype(object).to_numpy().tolist()]
