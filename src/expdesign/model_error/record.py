"""Hidden physics in documents (file-formats.md, evaluate --json; run.json; diagnosis.json)."""

from typing import Any

import numpy as np

from expdesign.criteria.assessment import Assessment
from expdesign.design.front import Front
from expdesign.design.problem import DesignProblem
from expdesign.model_error.hidden_physics import HiddenPhysics, hidden_physics
from expdesign.model_error.meir import Meir
from expdesign.model_error.statement import AccuracyStatement
from expdesign.model_error.words import sentence


def meir_of_problem(problem: DesignProblem) -> Meir | None:
    """The MEIR that a configuration asks for, or None."""
    return next((criterion for criterion in problem.further if isinstance(criterion, Meir)), None)


def hidden_by_plan(meir: Meir, assessment: Assessment) -> tuple[tuple[HiddenPhysics, ...], int]:
    """What the first design of an assessment hides, the worst first, and its degrees of freedom.

    Empty where the design does not identify what the targets need.
    """
    impact = meir.impact
    found = impact.hidden(assessment)
    freedom = int(found.freedom[0])
    if not np.isfinite(found.squares[0]).all():
        return (), freedom
    return hidden_physics(found, impact.physics, impact.deviations, 0), freedom


def recommended_accuracy(problem: DesignProblem, front: Front) -> AccuracyStatement | None:
    """What the recommended design of a front promises and hides; None where MEIR is not asked for."""
    meir = meir_of_problem(problem)
    if meir is None:
        return None
    assessment = problem.assessed(front.decisions[[front.recommended]])
    return AccuracyStatement.of(assessment, *hidden_by_plan(meir, assessment), "the recommended plan")


def hidden_record(physics: tuple[HiddenPhysics, ...], freedom: int, readings: str) -> dict[str, Any] | None:
    """What is hidden: the worst as a sentence, and every effect; None where nothing is known of it."""
    if not physics:
        return None
    return {
        "meir": physics[0].error,
        "freedom": freedom,
        "sentence": sentence(physics[0], freedom, readings),
        "effects": [_effect(each) for each in physics],
    }


def _effect(each: HiddenPhysics) -> dict[str, Any]:
    return {
        "physics": each.physics,
        "component": each.component,
        "variant": each.variant,
        "error": each.error,
        "parameters": each.parameters,
        "noticed": _finite(each.noticed),
        "tolerable": _finite(each.tolerable),
        "limited_by": each.limited_by,
    }


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
