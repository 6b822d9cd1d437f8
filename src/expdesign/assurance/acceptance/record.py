"""`verification.json`: what a check measurement says, as one document."""

import hashlib
import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from expdesign.assurance.acceptance.about import About
from expdesign.assurance.acceptance.verification import AxisResult, TargetResult, Verification
from expdesign.mechanics.robots.robot import Robot

RULE = (
    "an axis conforms where |e| + U does not exceed its tolerance, e being the measured error and U the expanded "
    "uncertainty of its measurement (ISO 14253-1; JCGM 106:2012, 8.3); the robot passes where every axis conforms"
)


def certificate_number(record: Mapping[str, Any]) -> str:
    """A number that follows from everything that a certificate states: twelve digits of the record's SHA-256."""
    digits = hashlib.sha256(json.dumps(record, sort_keys=True).encode()).hexdigest()[:12].upper()
    return "-".join(digits[start : start + 4] for start in (0, 4, 8))


def verification_record(
    result: Verification, robot: Robot, axes: tuple[str, ...], about: About, files: Mapping[str, str]
) -> dict[str, Any]:
    """The document.

    Args:
        result: what was found.
        robot: the robot.
        axes: deflection columns of the measured components.
        about: texts of the certificate.
        files: SHA-256 of every file, by its name.
    """
    comparison = result.comparison
    return {
        "verdict": result.verdict,
        "decision_rule": RULE,
        "coverage": result.coverage.level,
        "coverage_factor": result.coverage.factor,
        "consumer_risk": result.risk,
        "readings_needed": result.readings_needed,
        "model_refuted": result.model_refuted,
        "statement": result.statement.record,
        "model_test": {
            "consistent": result.consistent,
            "significance": result.statement.options.refuted,
            "chi2": comparison.chi2,
            "dof": comparison.residuals.size,
            "p_value": result.statement.p_value,
            "largest_z": float(np.abs(comparison.z).max()),
            "least_adjusted_p_value": float(comparison.adjusted.min()),
        },
        "targets": [_target(target, robot) for target in result.targets],
        "rows": [
            {
                "axes": list(axes),
                "attained": comparison.attained[row].tolist(),
                "predicted": comparison.predicted[row].tolist(),
                "z": comparison.z[row].tolist(),
                "adjusted_p_value": comparison.adjusted[row].tolist(),
            }
            for row in range(len(comparison.attained))
        ],
        "about": about.model_dump(),
        "files": dict(files),
    }


def _target(target: TargetResult, robot: Robot) -> dict[str, Any]:
    return {
        "target": dict(zip(robot.configuration, target.configuration.tolist(), strict=True)),
        "measurements": len(target.rows),
        "passes": target.passes,
        "measurements_needed": target.measurements_needed,
        "axes": [_axis(axis) for axis in target.axes],
    }


def _axis(axis: AxisResult) -> dict[str, Any]:
    return {
        "axis": axis.axis,
        "error": axis.error,
        "standard_uncertainty": axis.uncertainty,
        "expanded_uncertainty": axis.expanded,
        "tolerance": axis.tolerance,
        "conformity": axis.conformity,
    }
