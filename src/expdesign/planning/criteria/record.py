"""Criteria of one design and the matrices behind them, as one document (file-formats.md, evaluate --json)."""

from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import Criterion, known_criteria


def evaluation_record(assessment: Assessment, further: tuple[Criterion, ...] = ()) -> dict[str, Any]:
    """The document of the first design of an assessment; what cannot be identified is null.

    Args:
        assessment: of the design.
        further: criteria beside the known ones.
    """
    record: dict[str, Any] = {
        criterion.name: _number(criterion.values(assessment)[0]) for criterion in (*known_criteria().values(), *further)
    }
    record["rank"] = int(assessment.rank[0])
    record["condition"] = _number(assessment.condition[0])
    record["identifies_targets"] = bool(assessment.identifies_targets[0])
    targets = []
    sensitivity = assessment.force_sensitivity()[0]
    for index, estimable in enumerate(assessment.estimable[0]):
        noise, force = assessment.noise_root[0, index], assessment.force_root[0, index]
        both = np.outer(estimable, estimable)
        targets.append(
            {
                "U": _matrix(noise @ noise.T, both),
                "Z": _matrix(sensitivity[index], np.broadcast_to(estimable[:, None], sensitivity[index].shape)),
                "cov_fe": _matrix(force @ force.T, both),
            }
        )
    record["targets"] = targets
    return record


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _matrix(values: FloatArray, known: FloatArray) -> list[list[float | None]]:
    return [
        [float(value) if is_known else None for value, is_known in zip(row, mask, strict=True)]
        for row, mask in zip(values, known, strict=True)
    ]
