"""The acceptance of the design that a search recommends."""

from expdesign.acceptance.budget import planned_budget
from expdesign.acceptance.decision import Decision
from expdesign.design.front import Front
from expdesign.design.problem import DesignProblem


def recommended_acceptance(problem: DesignProblem, front: Front) -> Decision:
    """The decision on the recommended design's plan."""
    chosen = front.decisions[front.recommended][None]
    return Decision(planned_budget(problem, problem.assess(*problem.space.decode(chosen))))
