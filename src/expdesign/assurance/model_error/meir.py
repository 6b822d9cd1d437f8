"""MEIR: how far physics that the model leaves out may reach the position without being noticed (theory.md 21)."""

from functools import cached_property
from typing import Self

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.model_error.directions import Directions
from expdesign.assurance.model_error.hidden import Hidden, hidden_errors
from expdesign.assurance.model_error.left_out import Omitted, effects_of_problem, left_out
from expdesign.assurance.model_error.prior import prior_deviations, with_steps
from expdesign.assurance.model_error.settings import Assumptions
from expdesign.errors import InputError
from expdesign.io.yaml_reader import YamlDocument
from expdesign.planning.asked_criterion import AskedCriterion
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.targets import Targets
from expdesign.planning.problem import DesignProblem
from expdesign.planning.schema import ModelErrorsSection, RunSection


class Meir(AskedCriterion):
    """The largest MEIR_e over the effects that are considered.

    Args:
        problem: whose plans are meant.
        assumptions: of MEIR.
        physics: what is left out; everything that the robot can have where it is not given.

    Raises:
        InputError: nothing else than the stiffness is calibrated, or the assumptions do not suit the robot.
    """

    name = "meir"
    title = "MEIR (what the model leaves out)"
    unit = "tolerances"
    root_mean_square = True
    differentiable = False

    def __init__(
        self,
        problem: DesignProblem,
        assumptions: Assumptions | None = None,
        physics: tuple[Omitted, ...] | None = None,
    ) -> None:
        problem.require_elastostatic("MEIR is defined")
        self.problem, self.assumptions = problem, assumptions or Assumptions()
        if physics is None:
            physics = with_steps(problem, left_out(*effects_of_problem(problem), self.assumptions), self.assumptions)
        self.physics = physics
        known = None if problem.found is None else problem.found.physics
        self.directions = Directions(problem.loaded.robot, physics, known)

    @classmethod
    def asked(cls, problem: DesignProblem, section: RunSection, document: YamlDocument) -> Self:
        """Raises `InputError`: no physics is left, a name is unknown, a size not positive, or there is no such test."""
        given = section.model_error or ModelErrorsSection()
        named = None if given.physics is None else frozenset(given.physics)
        try:
            assumptions = Assumptions(given.level, given.power, named, frozenset(given.without))
            return cls(problem, assumptions.with_sizes(given.sizes))
        except InputError as error:
            where = f"{document.source}, {error.where}" if error.where else document.source
            raise InputError(error.what, where=where, remedy=error.remedy) from None

    @cached_property
    def errors(self) -> FloatArray:
        """Weighted deflections of the targets per compliance (1/apK) and per parameter, (blocks, q, n_p + D)."""
        return target_errors(self.problem, self.directions)

    @cached_property
    def deviations(self) -> FloatArray:
        """Prior sizes of all columns, shape (D,)."""
        flat = self.errors.reshape(-1, self.errors.shape[-1])
        return prior_deviations(self.problem, self.physics, self.assumptions, flat)

    @property
    def scaled_errors(self) -> FloatArray:
        """`errors` per compliance and in units of the prior sizes."""
        return self.errors * np.concatenate([np.ones(len(self.problem.loaded.robot.stiffness)), self.deviations])

    def whitened(self, assessment: Assessment) -> tuple[FloatArray, FloatArray]:
        """Ã in units of 1/apK (b, M, n_p) and B̃ in the parameters' own units (b, M, D) of b designs."""
        assert assessment.states is not None
        rows = self.directions.at(self.problem.loaded.load, *assessment.states, assessment.measurements.jacobians)
        return assessment.whitened * self.problem.loaded.robot.compliance, assessment.white(rows)

    def hidden(self, assessment: Assessment) -> Hidden:
        """What the designs of an assessment by this problem hide."""
        base, directions = self.whitened(assessment)
        return hidden_errors(base, directions * self.deviations, self.scaled_errors, self.physics, self.assumptions)

    def values(self, assessment: Assessment) -> FloatArray:
        return np.sqrt(self.hidden(assessment).squares.max(axis=1))


def target_errors(problem: DesignProblem, directions: Directions) -> FloatArray:
    """√(w_t/Σw)·W_t^½·S_t·[A_t·diag(1/apK), T_t] of the axes that matter, shape (blocks, q, n_p + D).

    One block of all targets where their mean counts, a block per target where the worst does.
    """
    targets: Targets = problem.targets
    compliance = problem.loaded.robot.compliance
    rows = []
    for index, (loaded, parameters) in enumerate(problem.target_loads):
        moved = directions.at_target(loaded.load, targets.configurations[index], parameters)
        if targets.axes is not None:
            moved = targets.axes[index] @ moved
        both = np.concatenate([targets.observation[index] * compliance, moved], axis=1)
        rows.append(np.sqrt(targets.importance[index])[:, None] * both)
    stacked = np.array(rows)
    if targets.aggregate == "max":
        return stacked
    weighted = np.sqrt(targets.weights / targets.weights.sum())[:, None, None] * stacked
    flat = weighted.reshape(1, -1, stacked.shape[-1])
    return flat[:, (targets.importance > 0.0).ravel()]
