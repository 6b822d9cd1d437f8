"""What a model that recordings determined says at the targets of a configuration: acceptance, and what may be hidden.

Most recordings are identified without targets, and need not wait for planning.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.acceptance.budget import NOISE, UncertaintyBudget
from expdesign.assurance.acceptance.decision import Decision, acceptance_record, sentences
from expdesign.assurance.acceptance.fitted import FittedModel
from expdesign.assurance.acceptance.left_out import decided_by
from expdesign.assurance.model_error.planned import meir_of_problem
from expdesign.assurance.model_error.recorded import HiddenByRecordings, hidden_by
from expdesign.assurance.model_error.statement import AccuracyStatement, given_variances, hidden_record, hidden_sentence
from expdesign.chain.recordings.recordings import Recordings
from expdesign.estimation.identify import Identification
from expdesign.estimation.whitening import Whitening
from expdesign.planning.problem import DesignProblem

if TYPE_CHECKING:
    from expdesign.diagnosis.result import Diagnosis
    from expdesign.report.blocks import PageSection


@dataclass(frozen=True)
class AtTargets:
    """What recordings, and the model that they determined, say at the targets of a configuration.

    Attributes:
        configuration: its path.
        acceptance: whether the robot is accepted.
        hidden: what the recordings may hide; None where that is not asked, or the model does not explain them.
        accuracy: the same beside noise and load errors.
    """

    configuration: str
    acceptance: Decision
    hidden: HiddenByRecordings | None = None
    accuracy: AccuracyStatement | None = None

    @property
    def hidden_sentence(self) -> str | None:
        """What may still be hidden, in words."""
        hidden = self.hidden
        return None if hidden is None else hidden_sentence(hidden.physics, hidden.freedom, self.accuracy)

    @property
    def lines(self) -> list[str]:
        """The decision, and what may still be hidden: a line for each sentence."""
        hidden = self.hidden_sentence
        return [*sentences(self.acceptance), *([] if hidden is None else [hidden])]

    @property
    def record(self) -> dict[str, Any]:
        """What a document says of it."""
        record: dict[str, Any] = {"acceptance": acceptance_record(self.acceptance)}
        if self.hidden is not None:
            record["hidden"] = hidden_record(self.hidden.physics, self.hidden.freedom, "these recordings")
            record["accuracy"] = None if self.accuracy is None else self.accuracy.record
        return record

    def sections(self, of: str, *, in_words: bool = True) -> "list[PageSection]":
        """The sections of a page about the model that `of` names; `in_words` where the page has not said them yet."""
        from expdesign.report.error_budget import acceptance_section  # noqa: PLC0415 (slow to import)
        from expdesign.report.hidden_physics import recordings_section  # noqa: PLC0415 (slow to import)

        hidden = (
            [] if self.hidden is None else [recordings_section(self.hidden, self.hidden_sentence if in_words else None)]
        )
        return [acceptance_section(self.acceptance, of), *hidden]


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


def identified_at_targets(problem: DesignProblem, result: Identification) -> AtTargets:
    """What an identification says at the targets; what may be hidden where the configuration asks for MEIR."""
    decision = accept_identified(problem, result)
    if meir_of_problem(problem) is None:
        return AtTargets(problem.source, decision)
    return with_hidden(problem, result.recordings.rows(result.fitted), result.noise.deviations, decision)


def with_hidden(
    problem: DesignProblem, recordings: Recordings, deviations: FloatArray, decision: Decision
) -> AtTargets:
    """A decision with what recordings may hide at the targets, and the accuracy to expect.

    Args:
        problem: with the targets.
        recordings: that the model explains.
        deviations: standard deviations of the readings.
        decision: with the budget of the model at the targets.
    """
    meir = meir_of_problem(problem)
    hidden = hidden_by(problem, recordings, deviations, None if meir is None else meir.assumptions)
    return AtTargets(problem.source, decision, hidden, _accuracy(problem, decision.budget, hidden))


def _accuracy(
    problem: DesignProblem, budget: UncertaintyBudget, hidden: HiddenByRecordings
) -> AccuracyStatement | None:
    parts = {True: np.zeros(budget.tolerance.shape), False: np.zeros(budget.tolerance.shape)}
    for each in budget.contributions:
        parts[each.name == NOISE] += each.deviation**2
    variances = given_variances(problem.targets, np.sqrt(parts[True]), np.sqrt(parts[False]))
    return AccuracyStatement.of(variances, hidden.physics, hidden.freedom, "these recordings")
