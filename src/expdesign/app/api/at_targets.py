"""What a model that recordings determined says at the targets of a configuration: acceptance, and what may be hidden.

Most recordings are identified without targets, and need not wait for planning.
"""

from typing import TYPE_CHECKING

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.acceptance.budget import NOISE, UncertaintyBudget
from expdesign.assurance.acceptance.decision import Decision
from expdesign.assurance.acceptance.fitted import FittedModel
from expdesign.assurance.acceptance.left_out import decided_by
from expdesign.assurance.model_error.planned import meir_of_problem
from expdesign.assurance.model_error.recorded import HiddenByRecordings, hidden_by
from expdesign.assurance.model_error.statement import AccuracyStatement, given_variances
from expdesign.chain.recordings.recordings import Recordings
from expdesign.estimation.identify import Identification
from expdesign.estimation.whitening import Whitening
from expdesign.planning.problem import DesignProblem

if TYPE_CHECKING:
    from expdesign.diagnosis.result import Diagnosis

Hidden = tuple[HiddenByRecordings, AccuracyStatement | None]
"""What recordings may hide, and the accuracy to expect with it."""


def accept_identified(problem: DesignProblem, result: Identification) -> Decision:
    """Whether an identified robot is accepted at the targets of a configuration; not decided where it is refuted."""
    noise, recorded = result.noise, result.recordings.rows(result.fitted)
    whitening = Whitening(noise.deviations, references=recorded.references)
    degrees = min((group.dof for group in noise.groups), default=float("inf"))
    model = FittedModel(result.fit, recorded, whitening, float(degrees))
    return decided_by(problem, model, refuted=result.goodness.refuted)


def accept_diagnosed(problem: DesignProblem, result: "Diagnosis") -> Decision:
    """Whether the robot is accepted at the targets of a configuration with the model that was found.

    Nothing is decided where that model is no explanation of the recordings.
    """
    sample = result.names.sample.restricted(~result.predictive.outliers)
    counts, recorded = sample.counts, result.recordings.rows(sample.counts)
    whitening = sample.whitening.rows(counts)
    degrees = float("inf") if result.noise.known else float(max(result.after.dof, 1))
    model = FittedModel(result.known.seen_by(counts), recorded, whitening, degrees)
    remedy = "record what separates the explanations, or look at the place that is named"
    return decided_by(problem, model, refuted=result.refuted, remedy=remedy)


def hidden_by_identified(problem: DesignProblem, result: Identification, decision: Decision) -> Hidden | None:
    """What the recordings of an identification hide, where the configuration asks for MEIR; else None."""
    if meir_of_problem(problem) is None:
        return None
    recorded = result.recordings.rows(result.fitted)
    return hidden_at_targets(problem, recorded, result.noise.deviations, decision)


def hidden_at_targets(
    problem: DesignProblem, recordings: Recordings, deviations: FloatArray, decision: Decision
) -> Hidden:
    """What recordings may hide at the targets, and the accuracy to expect: their budget with what they may hide.

    Args:
        problem: with the targets.
        recordings: that the model explains.
        deviations: standard deviations of the readings.
        decision: with the budget of the model at the targets.
    """
    meir = meir_of_problem(problem)
    hidden = hidden_by(problem, recordings, deviations, None if meir is None else meir.assumptions)
    return hidden, _accuracy(problem, decision.budget, hidden)


def _accuracy(
    problem: DesignProblem, budget: UncertaintyBudget, hidden: HiddenByRecordings
) -> AccuracyStatement | None:
    parts = {True: np.zeros(budget.tolerance.shape), False: np.zeros(budget.tolerance.shape)}
    for each in budget.contributions:
        parts[each.name == NOISE] += each.deviation**2
    variances = given_variances(problem.targets, np.sqrt(parts[True]), np.sqrt(parts[False]))
    return AccuracyStatement.of(variances, hidden.physics, hidden.freedom, "these recordings")
