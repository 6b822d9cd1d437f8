"""`evaluate`: every criterion of one given plan."""

from __future__ import annotations

from expdesign.app.api.arguments import named_arguments
from expdesign.app.api.configuration import Config, plan_of, problem_of
from expdesign.app.api.inputs import TableInput, purpose_of
from expdesign.planning.plan import require_whole_load, without_validation
from expdesign.report.plan_results import EvaluationResult


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
    unidentified = problem.unidentified(assessment, read.table.source)
    return EvaluationResult(problem, given, assessment, unidentified, purpose=purpose_of("evaluate", config, plan))
