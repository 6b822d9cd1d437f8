"""What a plan hides, where its configuration asks for MEIR."""

import numpy as np

from expdesign.assurance.model_error.meir import Meir
from expdesign.assurance.model_error.statement import AccuracyStatement, HiddenPhysics, hidden_physics
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.front import Front
from expdesign.planning.problem import DesignProblem


def meir_of_problem(problem: DesignProblem) -> Meir | None:
    """The MEIR that a configuration asks for, or None."""
    return next((criterion for criterion in problem.further if isinstance(criterion, Meir)), None)


def hidden_by_plan(meir: Meir, assessment: Assessment) -> tuple[tuple[HiddenPhysics, ...], int]:
    """What the first design of an assessment hides, the worst first, and its degrees of freedom.

    Empty where the design does not identify what the targets need.
    """
    found = meir.hidden(assessment)
    freedom = int(found.freedom[0])
    if not np.isfinite(found.squares[0]).all():
        return (), freedom
    return hidden_physics(found, meir.physics, meir.deviations), freedom


def recommended_accuracy(problem: DesignProblem, front: Front) -> AccuracyStatement | None:
    """What the recommended design of a front promises and hides; None where MEIR is not asked for."""
    meir = meir_of_problem(problem)
    if meir is None:
        return None
    assessment = problem.assessed(front.decisions[[front.recommended]])
    return AccuracyStatement.of(assessment, *hidden_by_plan(meir, assessment), "the recommended plan")
