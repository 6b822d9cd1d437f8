"""What a model that recordings determined says at the targets of a configuration: acceptance, and what may be hidden.

Most recordings are identified without targets, and need not wait for planning.
"""

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from expdesign.assurance.acceptance.budget import NOISE, UncertaintyBudget
from expdesign.assurance.acceptance.decision import Decision, undecided
from expdesign.assurance.acceptance.fitted import FittedModel
from expdesign.assurance.acceptance.hidden_risk import decided_by, left_out_by
from expdesign.assurance.model_error.recorded import Shown
from expdesign.assurance.model_error.statement import AccuracyStatement, WhatIsHidden
from expdesign.estimation.identify import Identification
from expdesign.estimation.load_errors import load_columns
from expdesign.estimation.remarks import Implausible
from expdesign.planning.criteria.targets import GivenVariances
from expdesign.planning.problem import DesignProblem
from expdesign.report.error_budget import StatedAtTargets

if TYPE_CHECKING:
    from expdesign.diagnosis.result import Diagnosis


class AtTargets:
    """A model at the targets of a configuration.

    Args:
        problem: with the targets.
        model: as its recordings determined it.
        refuted: whether they refute it, so that nothing is decided.
        remedy: what to do then.
        otherwise: whether the recordings fit only if they are read otherwise, so that nothing is decided either.
    """

    def __init__(
        self,
        problem: DesignProblem,
        model: FittedModel,
        refuted: bool,
        remedy: str = "run `expdesign diagnose`",
        otherwise: bool = False,
    ) -> None:
        self.problem, self.model, self.refuted, self.remedy = problem, model, refuted, remedy
        self.otherwise = otherwise

    @classmethod
    def identified(cls, problem: DesignProblem, result: Identification) -> "AtTargets":
        """An identified robot; not decided where it is refuted."""
        noise, recorded = result.noise, result.recordings.rows(result.fitted)
        drawn = None if result.arm is None else result.arm.drawn
        model = FittedModel(result.fit, recorded, result.whitening, noise.degrees, result.loads, drawn)
        otherwise = any(isinstance(each, Implausible) and each.otherwise for each in result.suspicions)
        return cls(problem, model, result.goodness.refuted, otherwise=otherwise)

    @classmethod
    def diagnosed(cls, problem: DesignProblem, result: "Diagnosis") -> "AtTargets":
        """The model that a diagnosis found; nothing is decided where it is no explanation of the recordings."""
        sample = result.names.sample
        counts, recorded = sample.counts, result.recordings.rows(sample.counts)
        whitening, known = sample.whitening, result.known
        if result.loads is not None:
            weighs = result.loads.weights.any()
            whitening = whitening.weighing(load_columns(result.loads.effects, result.loads.weights) if weighs else None)
        degrees = result.noise.degrees
        if result.noise.origin == "residuals":  # what was found takes some
            degrees = min(degrees, float(max(result.after.dof, 1)))
        model = FittedModel(
            known.seen_by(counts), recorded, whitening.rows(counts), degrees, result.loads, result.drawn
        )
        remedy = "record what separates the explanations, or look at the place that is named"
        return cls(problem, model, result.refuted, remedy, any(doubt.otherwise for doubt in result.doubts))

    @cached_property
    def _left_out(self) -> Shown | None:
        return None if self.refuted else left_out_by(self.problem, self.model)

    @cached_property
    def decision(self) -> Decision:
        """Whether the robot is accepted."""
        found = decided_by(self.problem, self.model, self._left_out, refuted=self.refuted, remedy=self.remedy)
        return undecided(found) if self.otherwise else found

    def stated(self, *, hidden: bool) -> StatedAtTargets:
        """What is said of it; with `hidden`, what recordings that the base model explains may hide as well."""
        if not hidden:
            return StatedAtTargets(self.problem.source, self.decision)
        shown = None if self.model.fit.chain.effects else self._left_out
        found = (shown or Shown(self.problem, self.model.recordings, self.model.whitening)).hidden()
        accuracy = _accuracy(self.problem, self.decision.budget, found)
        return StatedAtTargets(self.problem.source, self.decision, found, accuracy)


def _accuracy(problem: DesignProblem, budget: UncertaintyBudget, hidden: WhatIsHidden) -> AccuracyStatement | None:
    parts = {True: np.zeros(budget.tolerance.shape), False: np.zeros(budget.tolerance.shape)}
    for each in budget.contributions:
        parts[each.name == NOISE] += each.deviation**2
    matters = problem.targets.importance > 0.0
    noise, load_errors = (np.where(matters, parts[kind], 0.0) for kind in (True, False))
    return AccuracyStatement.of(GivenVariances(problem.targets, noise, load_errors), hidden)
