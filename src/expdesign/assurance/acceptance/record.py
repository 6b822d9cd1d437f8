"""`verification.json`: what a check measurement says, as one document, with the texts of its certificate."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from expdesign.assurance.acceptance.verification import AxisResult, TargetResult, Verification
from expdesign.errors import InputError
from expdesign.io.nearest import nearest
from expdesign.io.schema import Section, validate
from expdesign.io.yaml_reader import read_yaml
from expdesign.mechanics.robots.robot import Robot

RULE = (
    "an axis conforms where |e| + U does not exceed its tolerance, e being the measured error and U the expanded "
    "uncertainty of its measurement (ISO 14253-1; JCGM 106:2012, 8.3); the robot passes where every axis conforms"
)


class About(Section):
    """Texts of a certificate; empty ones are left to be filled in by hand."""

    laboratory: str = ""
    robot: str = ""
    serial_number: str = ""
    load: str = ""
    instrument: str = ""
    environment: str = ""
    operator: str = ""
    date: str = ""
    remarks: str = ""


def read_about(path: Path) -> About:
    """The texts of a YAML file.

    Raises:
        InputError: a key is unknown, or a value is no text.
    """
    document = read_yaml(path)
    if not isinstance(document.content, dict):
        remedy = f"Keys: {', '.join(About.model_fields)}."
        raise InputError("a mapping (`key: value`) is needed here", where=document.where(), remedy=remedy)
    # YAML reads 2026-03-01 as a date; on a certificate it is a text.
    texts = {key: str(value) if key == "date" else value for key, value in document.content.items()}
    return validate(About, replace(document, content=texts))


def about_of(texts: dict[str, str]) -> About:
    """The texts of a mapping.

    Raises:
        InputError: a key is unknown.
    """
    known = list(About.model_fields)
    for name in texts:
        if name not in known:
            raise InputError(f"unknown key `{name}`", where="about", remedy=nearest(name, known))
    return About(**texts)


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
