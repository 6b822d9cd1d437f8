"""MEIR: how far physics that the model leaves out may reach the position without being noticed (theory.md 21)."""

from functools import cached_property
from typing import Self

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.model_error.hidden import Hidden, hidden_errors
from expdesign.assurance.model_error.left_out import (
    Directions,
    Omitted,
    effects_of_problem,
    left_out,
    plan_points,
    prior_deviations,
    target_points,
    with_steps,
)
from expdesign.assurance.model_error.settings import Assumptions
from expdesign.chain.chain import Chain
from expdesign.chain.row import RowData, row_data
from expdesign.errors import InputError
from expdesign.io.yaml_reader import YamlDocument
from expdesign.planning.asked_criterion import AskedCriterion
from expdesign.planning.criteria.assessment import Assessment
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
        known, robot = None if problem.found is None else problem.found.physics, problem.loaded.robot
        chain, values = (Chain(robot), np.ones(len(robot.stiffness))) if known is None else (known.chain, known.values)
        self.directions = Directions(Chain(chain.robot, chain.effects), values, physics)

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
    def motions(self) -> FloatArray:
        """How each parameter moves the platform at the targets along the axes of the tolerances, shape (t, n, D)."""
        return self._along_axes([self.directions.of_platform(point)[0] for point in self._points])

    def moved_by(self, index: int, size: float) -> FloatArray:
        """How physics with a step moves the platform there at a size in its prior ones, shape (t, n)."""
        change = [self.directions.change(index, point, size, platform=True)[0] for point in self._points]
        return self._along_axes(change)

    @cached_property
    def _points(self) -> list[RowData]:
        robot, count = self.directions.base.robot, len(self.problem.targets.configurations)
        return [row_data(target_points(self.problem, index), robot) for index in range(count)]

    def _along_axes(self, moved: list[FloatArray]) -> FloatArray:
        axes = self.problem.targets.axes
        return np.array(moved if axes is None else [turned @ each for turned, each in zip(axes, moved, strict=True)])

    @cached_property
    def errors(self) -> FloatArray:
        """√(w_t/Σw)·W_t^½·S_t·[A_t·diag(1/apK), T_t] of the axes that matter, shape (blocks, q, n_p + D).

        One block of all targets where their mean counts, a block per target where the worst does.
        """
        targets = self.problem.targets
        both = np.concatenate([targets.observation * self.problem.loaded.robot.compliance, self.motions], axis=2)
        stacked = np.sqrt(targets.importance)[..., None] * both
        if targets.aggregate == "max":
            return stacked
        weighted = np.sqrt(targets.weights / targets.weights.sum())[:, None, None] * stacked
        flat: FloatArray = weighted.reshape(1, -1, stacked.shape[-1])
        return flat[:, (targets.importance > 0.0).ravel()]

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
        configurations, loads = assessment.states
        flat = (each.reshape(-1, each.shape[-1]) for each in (configurations, loads))
        points = plan_points(self.problem.loaded, *flat)
        rows = self.directions.at(row_data(points, self.directions.base.robot))[1]
        rows = rows.reshape(*configurations.shape[:2], *rows.shape[1:])
        return assessment.whitened * self.problem.loaded.robot.compliance, assessment.white(rows)

    def hidden(self, assessment: Assessment) -> Hidden:
        """What the designs of an assessment by this problem hide."""
        base, directions = self.whitened(assessment)
        return hidden_errors(base, directions * self.deviations, self.scaled_errors, self.physics, self.assumptions)

    def values(self, assessment: Assessment) -> FloatArray:
        return np.sqrt(self.hidden(assessment).squares.max(axis=1))


def meir_of_problem(problem: DesignProblem) -> Meir | None:
    """The MEIR that a configuration asks for, or None."""
    return next((criterion for criterion in problem.further if isinstance(criterion, Meir)), None)
