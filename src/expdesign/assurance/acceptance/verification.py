"""What a check measurement says of a model and of a robot, and `verification.json`.

Two questions, two tests: does the model predict what was attained (`attained`), and does the robot attain its
tolerances (`conformity`)? Only proven conformity passes; an axis that is beyond its tolerance then passes with a
probability of at most Φ(−k), and so does a robot with at least one such axis, since all axes have to pass (Berger
1982). A robot fails where an axis is proven to be beyond its tolerance; otherwise conformity is not proven.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import ndtr

from expdesign.assurance.acceptance.attained import Comparison
from expdesign.assurance.acceptance.certificate import About
from expdesign.assurance.acceptance.conformity import TargetResult
from expdesign.estimation.coverage import Coverage
from expdesign.estimation.goodness import REFUTED, StatementOfFit
from expdesign.mechanics.robots.robot import Robot

RULE = (
    "an axis conforms where |e| + U does not exceed its tolerance, e being the measured error and U the expanded "
    "uncertainty of its measurement (ISO 14253-1; JCGM 106:2012, 8.3); the robot passes where every axis conforms"
)


@dataclass(frozen=True)
class Verification:
    """What a check measurement says.

    Attributes:
        comparison: attained against predicted.
        statement: whether the model predicts what was attained.
        targets: attained against tolerance.
        coverage: of the expanded uncertainties.
        model_refuted: whether the model's own recordings refute it.
    """

    comparison: Comparison
    statement: StatementOfFit
    targets: tuple[TargetResult, ...]
    coverage: Coverage
    model_refuted: bool = False

    @property
    def consistent(self) -> bool:
        """Whether the model predicts what was attained."""
        return not self.statement.refuted

    @property
    def decided(self) -> bool:
        """Whether any axis has a tolerance."""
        return any(target.decided for target in self.targets)

    @property
    def verdict(self) -> str:
        """`pass`, `fail` (an axis is proven to be beyond its tolerance), `not proven`, or `no tolerance`."""
        if not self.decided:
            return "no tolerance"
        if all(target.passes for target in self.targets):
            return "pass"
        return "fail" if any("does not conform" in target.conformity for target in self.targets) else "not proven"

    @property
    def off_target(self) -> bool:
        """Whether the configuration's tolerances are of targets at none of which there is a reading."""
        with_tolerance = [target for target in self.targets if target.decided]
        return bool(with_tolerance) and all(len(target.rows) == 0 for target in with_tolerance)

    @property
    def readings_needed(self) -> int | None:
        """How many independent readings of every target with a tolerance would prove conformity; None where no number
        is known to.
        """
        judged = [target for target in self.targets if target.decided]
        needed = [target.measurements_needed for target in judged if not target.passes]
        taken = [len(target.rows) for target in judged if target.passes]
        if None in needed:
            return None
        return max([*taken, *(count for count in needed if count is not None)], default=None)

    @property
    def risk(self) -> float:
        """Largest probability with which a robot that is beyond a tolerance passes: Φ(−k)."""
        return float(ndtr(-self.coverage.factor))


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
            "significance": REFUTED,
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
    columns = {
        "error": target.error,
        "standard_uncertainty": target.uncertainty,
        "expanded_uncertainty": target.expanded,
        "tolerance": target.tolerance,
    }
    axes = [
        {
            "axis": robot.coordinates.deflection[axis],
            **{name: float(each[axis]) if np.isfinite(each[axis]) else None for name, each in columns.items()},
            "conformity": str(target.conformity[axis]),
        }
        for axis in np.flatnonzero(np.isfinite(target.error) | target.matters)
    ]
    return {
        "target": dict(zip(robot.configuration, target.configuration.tolist(), strict=True)),
        "measurements": len(target.rows),
        "passes": target.passes,
        "measurements_needed": target.measurements_needed,
        "axes": axes,
    }
