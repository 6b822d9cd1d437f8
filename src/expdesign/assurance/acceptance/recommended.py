"""The acceptance of the design that a search recommends."""

from expdesign.assurance.acceptance.decision import Decision
from expdesign.assurance.acceptance.planned import planned_decision
from expdesign.planning.front import Front
from expdesign.planning.problem import DesignProblem


def recommended_acceptance(problem: DesignProblem, front: Front) -> Decision:
    """The decision on the recommended design's plan."""
    chosen = front.decisions[front.recommended][None]
    return planned_decision(problem, problem.assessed(chosen))
