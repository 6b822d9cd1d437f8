"""What `evaluate` and `next` return, and say of plans."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.assurance.acceptance.decision import Decision
from expdesign.assurance.acceptance.planned import planned_decisions
from expdesign.assurance.model_error.meir import meir_of_problem
from expdesign.assurance.model_error.statement import AccuracyStatement, WhatIsHidden, hidden_by_plan
from expdesign.chain.recordings.recordings import Recordings
from expdesign.counted import counted
from expdesign.errors import ExpdesignError
from expdesign.estimation.goodness import StatementOfFit
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.record import evaluation_record
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem
from expdesign.report.acceptance_texts import acceptance_record, beside_the_plan, sentences
from expdesign.report.blocks import table_of
from expdesign.report.result import Result, TableResult
from expdesign.report.said import Said


@dataclass(frozen=True, repr=False)
class EvaluationResult(Result):
    """A plan as the criteria see it.

    Attributes:
        problem: by which it is judged.
        plan: what is judged.
        assessment: the pieces of every criterion, for a batch of this one design.
        unidentified: the error that says what the plan cannot identify, or None.
    """

    problem: DesignProblem
    plan: Plan
    assessment: Assessment
    unidentified: ExpdesignError | None = None

    @property
    def said(self) -> Said:
        record = evaluation_record(self.assessment, self.problem.further)
        record["acceptance"] = acceptance_record(self.acceptance)
        if meir_of_problem(self.problem) is not None:
            record["hidden"] = None if self.hidden is None else self.hidden.record
            record["accuracy"] = None if self.accuracy is None else self.accuracy.record
        rows = [
            [
                criterion.title,
                "not identifiable" if record[name] is None else f"{record[name]:.6g}",
                criterion.unit,
                "larger" if criterion.maximise else "smaller",
            ]
            for name, criterion in self.problem.criteria.items()
        ]
        table = table_of("criteria", "Criteria of the plan.", ["Criterion", "Value", "Unit", "Better"], rows)
        accuracy = record.get("accuracy")
        lines = [*sentences(self.acceptance), *([accuracy["sentence"]] if accuracy else [])]
        values = [
            f"{name} {np.nan if record[name] is None else record[name]:.4g}" for name in ("duir", "feir", "total")
        ]
        notes = [] if self.unidentified is None else [f"expdesign: {self.unidentified.message}"]
        return Said(f"{', '.join(values)} tolerances", lines, notes, lambda: record, [table])

    @property
    def acceptance(self) -> Decision:
        """Expanded uncertainty, tolerance and pass or fail of every axis of every target."""
        return planned_decisions(self.problem, self.assessment)[0]

    @cached_property
    def hidden(self) -> WhatIsHidden | None:
        """What the plan hides; None where MEIR is not asked for, or the targets are not identified."""
        return hidden_by_plan(self.problem, self.assessment, "this plan")

    @property
    def accuracy(self) -> AccuracyStatement | None:
        """Noise, load errors and what may be hidden; None where MEIR is not asked for, or nothing is determined."""
        return AccuracyStatement.of(self.assessment, self.hidden)

    @property
    def total(self) -> float:
        """RMS error to expect after compensation, in tolerances; NaN where the targets are not identified."""
        return float(self.criteria["value"]["total"])

    @property
    def criteria(self) -> pd.DataFrame:
        """Value, unit and sense of every criterion, by its name; NaN where it cannot be identified."""
        known = self.problem.criteria
        columns = {
            "value": [float(criterion.values(self.assessment)[0]) for criterion in known.values()],
            "unit": [criterion.unit for criterion in known.values()],
            "better": ["larger" if criterion.maximise else "smaller" for criterion in known.values()],
        }
        return pd.DataFrame(columns, index=pd.Index(list(known), name="criterion"))


@dataclass(frozen=True, repr=False)
class NextResult(TableResult):
    """The next measurements, and what they are expected to achieve.

    Attributes:
        text: the plan of the next measurements, numbered on from the recordings.
        recordings: what was measured so far.
        before: expected total error now, in tolerances; infinite where the recordings do not determine it.
        after: the same with each further measurement, shape (k,).
        fit: whether the base model accounts for the recordings, or None where that is not tested, as for a robot whose
            diagnosis found more than the base model.
        undetermined: what the recordings alone do not determine, in words, or None.
        decisions: whether the robot is expected to pass now and with each further measurement, k + 1 of them.
        accuracy: expected error, in tolerances, at which it was to stop, or None.
    """

    recordings: Recordings
    before: float
    after: FloatArray
    fit: StatementOfFit | None
    undetermined: str | None
    decisions: tuple[Decision, ...]
    accuracy: float | None = None

    @property
    def said(self) -> Said:
        totals, decisions, accuracy, fit = self.totals, self.decisions, self.accuracy, self.fit
        lines, count = [], len(self.after)
        refuted, decided = fit is not None and fit.refuted, decisions[0].decided
        if fit is not None and refuted:
            lines += [
                f"{fit.sentence()} More of them will not help until `expdesign diagnose` has found why.",
                "What follows assumes that the base model is right.",
            ]
        if self.undetermined is not None:
            lines.append(f"so far: {self.undetermined}")
        enough = next((index for index, decision in enumerate(decisions) if decision.robot_passes), None)
        verdict = sentences(decisions[0])[0]
        if enough == 0 and decided and not refuted:
            verdict = f"{verdict} No further measurement is needed."
        lines.append(verdict)
        if accuracy is not None and totals[0] <= accuracy and decided and not refuted:
            lines.append(f"already within {accuracy:g} tolerances, the accuracy that was asked for")
        for index, total in enumerate(totals):
            when = f"with {index} more" if index else "expected total error now"
            lines.append(f"{when}: {f'{total:.4g} tolerances' if np.isfinite(total) else 'not determined'}")
        lines += beside_the_plan(decisions[0].budget)
        if accuracy is not None and totals[-1] > accuracy:
            lines.append(f"{count} more {'is' if count == 1 else 'are'} not enough for {accuracy:g} tolerances")
        if decided and enough:
            lines.append(f"with {enough} more the robot is expected to pass")
        elif decided and enough is None:
            lines.append(f"with {count} more the robot is still not expected to pass")
        return Said(counted(count, "further measurement"), lines)

    @property
    def totals(self) -> FloatArray:
        """Expected total error now and with each further measurement, shape (k + 1,)."""
        return np.concatenate([[self.before], self.after])
