"""`evaluate`: every criterion of one given plan."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import pandas as pd

from expdesign.app.api.configuration import Config, plan_of, problem_of
from expdesign.app.api.inputs import TableInput, named_arguments, purpose_of
from expdesign.app.api.result import Result
from expdesign.assurance.acceptance.decision import Decision
from expdesign.assurance.acceptance.planned import planned_decisions
from expdesign.assurance.model_error.meir import meir_of_problem
from expdesign.assurance.model_error.statement import AccuracyStatement, WhatIsHidden, hidden_by_plan
from expdesign.errors import ExpdesignError
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.record import evaluation_record
from expdesign.planning.plan import Plan, require_whole_load, without_validation
from expdesign.planning.problem import DesignProblem
from expdesign.report.acceptance_texts import acceptance_record
from expdesign.report.design_texts import evaluated
from expdesign.report.said import Said


@dataclass(frozen=True, repr=False)
class EvaluationResult(Result):
    """A plan as the criteria see it.

    Attributes:
        problem: by which it is judged.
        plan: what is judged.
        assessment: the pieces of every criterion, for a batch of this one design.
        remarks: what is doubtful about the plan, in words.
        unidentified: the error that says what the plan cannot identify, or None.
    """

    problem: DesignProblem
    plan: Plan
    assessment: Assessment
    remarks: tuple[str, ...]
    unidentified: ExpdesignError | None = None

    @property
    def said(self) -> Said:
        record = evaluation_record(self.assessment, self.problem.further)
        record["acceptance"] = acceptance_record(self.acceptance)
        if meir_of_problem(self.problem) is not None:
            record["hidden"] = None if self.hidden is None else self.hidden.record
            record["accuracy"] = None if self.accuracy is None else self.accuracy.record
        return evaluated(self.problem.criteria, record, self.acceptance, self.remarks)

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


@named_arguments
def evaluate(config: Config, plan: TableInput) -> EvaluationResult:
    """Judge one plan by every criterion.

    Args:
        config: run configuration (YAML).
        plan: plan (CSV), of any number of rows.

    Raises:
        InputError: a file is missing or wrong.
        SingularConfigurationError: the robot is singular, or nearly so, in one of the rows.

    Example:
        >>> round(xd.evaluate("configs/bipod.yaml", "plan.csv").record["total"], 3)  # tolerances
        0.615

    Command:
        expdesign evaluate configs/hexapod-h1.yaml results/mine/plan.csv --json
    """
    problem = problem_of(config)
    read = plan_of(plan, problem)
    require_whole_load(read.table, problem.loaded)
    given = without_validation(read.plan, read.table)
    assessment = problem.assess(given.configurations[None], given.loads[None], given.series[None])
    error = problem.unidentified(assessment, read.table.source)
    return EvaluationResult(
        problem,
        given,
        assessment,
        () if error is None else (error.message,),
        error,
        purpose=purpose_of("evaluate", config, plan),
    )
