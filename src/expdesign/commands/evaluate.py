"""`expdesign evaluate`: every criterion of one given plan."""

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table as RichTable

from expdesign.arrays import FloatArray
from expdesign.commands.console import note
from expdesign.criteria.assessment import Assessment
from expdesign.criteria.criterion import known_criteria
from expdesign.design.plan import Plan, completed, read_plan
from expdesign.design.problem import DesignProblem
from expdesign.design.problem_file import read_problem
from expdesign.design.search import all_criteria
from expdesign.errors import SingularConfigurationError
from expdesign.files.output import json_text
from expdesign.files.table import Table, read_table
from expdesign.recordings.reader import points_from_table
from expdesign.robots.robot import CONDITION_LIMIT


def command(
    config: Annotated[Path, typer.Argument(help="Run configuration (YAML).")],
    plan: Annotated[Path, typer.Argument(help="Plan (CSV), of any number of rows.")],
    json: Annotated[bool, typer.Option("--json", help="Print one JSON document on standard output.")] = False,
) -> None:
    """Judge one plan by every criterion.

    Example: expdesign evaluate configs/hexapod-h1.yaml results/mine/plan.csv --json
    """
    problem = read_problem(config)
    table = read_table(plan)
    given = read_plan(table, problem.loaded, shared_reference=problem.noise.shared_reference)
    points_from_table(completed(table, given, problem.loaded), problem.loaded.robot)  # units, numbering, contradictions
    assessment = assess_plan(problem, given, table)
    error = problem.unidentified(assessment)
    if error is not None:
        note(f"expdesign: {error.message}")
    record = evaluation_record(assessment)
    if json:
        print(json_text(record), end="")
        return
    shown = RichTable("criterion", "value", "unit", "better")
    for name, criterion in known_criteria().items():
        value = record[name]
        text = "not identifiable" if value is None else f"{value:.6g}"
        shown.add_row(criterion.title, text, criterion.unit, "larger" if criterion.maximise else "smaller")
    Console(soft_wrap=True).print(shown)


def assess_plan(problem: DesignProblem, plan: Plan, table: Table) -> Assessment:
    """The pieces of every criterion of one plan, shape (1, m).

    Raises:
        SingularConfigurationError: the robot is singular, or nearly so, in one of the rows.
    """
    robot = problem.loaded.robot
    condition = robot.jacobians(plan.configurations).condition
    if (condition > CONDITION_LIMIT).any():
        row = int(np.argmax(condition))
        what = f"the robot is singular or nearly so there (scaled condition number {condition[row]:.3g})"
        raise SingularConfigurationError(what, where=table.where(row), remedy="Choose another pose.")
    for index in np.flatnonzero(robot.limit_excess(plan.configurations) > 1e-9):
        message = robot.limit_message(plan.configurations[index])
        note(f"expdesign: {table.where(int(index))}: beyond the limits: {message}")
    return problem.assess(plan.configurations[None], plan.loads[None], plan.series[None])


def evaluation_record(assessment: Assessment) -> dict[str, Any]:
    """The document of `evaluate --json` (interfaces.md); what cannot be identified is null."""
    record: dict[str, Any] = {name: _number(values[0]) for name, values in all_criteria(assessment).items()}
    record["rank"] = int(assessment.rank[0])
    record["condition"] = _number(assessment.condition[0])
    record["identifies_targets"] = bool(assessment.identifies_targets[0])
    targets = []
    sensitivity = assessment.force_sensitivity()[0]
    for index, estimable in enumerate(assessment.estimable[0]):
        noise, force = assessment.noise_root[0, index], assessment.force_root[0, index]
        both = np.outer(estimable, estimable)
        targets.append(
            {
                "U": _matrix(noise @ noise.T, both),
                "Z": _matrix(sensitivity[index], np.broadcast_to(estimable[:, None], sensitivity[index].shape)),
                "cov_fe": _matrix(force @ force.T, both),
            }
        )
    record["targets"] = targets
    return record


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _matrix(values: FloatArray, known: FloatArray) -> list[list[float | None]]:
    return [
        [float(value) if is_known else None for value, is_known in zip(row, mask, strict=True)]
        for row, mask in zip(values, known, strict=True)
    ]
