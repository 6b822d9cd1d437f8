"""`plan_next`: the measurements that would most improve the accuracy at the targets (the command `next`).

Named so because `next` is a builtin function of Python.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
import pandas as pd

from expdesign.app.api.arguments import Seed, Within, named_arguments
from expdesign.app.api.configuration import Config, problem_of
from expdesign.app.api.inputs import TableInput, purpose_of, table_of
from expdesign.app.api.points_said import say_unknown_columns
from expdesign.app.api.recorded import correlated, referenced
from expdesign.arrays import FloatArray
from expdesign.assurance.acceptance.decision import undecided
from expdesign.assurance.acceptance.planned import informed_decision
from expdesign.assurance.plausibility.configured import recorded_findings
from expdesign.assurance.plausibility.finding import say
from expdesign.assurance.plausibility.recordings import recordings_findings
from expdesign.chain.recordings.columns import REFERENCE
from expdesign.chain.recordings.reader import recordings_from_table, require_measured
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.recordings.references import reference_names
from expdesign.errors import NotIdentifiableError
from expdesign.estimation.identify import fitted_rows
from expdesign.io.table import Table
from expdesign.planning.plan import Plan, plan_frame, read_plan
from expdesign.planning.problem import DesignProblem
from expdesign.planning.sequential import identified_so_far, next_measurements, recorded_knowledge, require_readings_of
from expdesign.report.plan_results import NextResult

MOST = 24
"""Measurements that are added at most in order to reach an accuracy."""
Count = Annotated[int | None, Within("a number of measurements", "Use at least 1.", 1)]
Accuracy = Annotated[float | None, Within("an accuracy", "Give tolerances, e.g. 0.8.", 0.0, strict=True)]


@named_arguments
def plan_next(
    config: Config,
    recordings: TableInput,
    *,
    count: Count = None,
    accuracy: Accuracy = None,
    seed: Seed = 1,
) -> NextResult:
    """Plan the next measurements, given what was measured.

    Args:
        config: run configuration (YAML).
        recordings: what was measured so far (CSV).
        count: number of measurements; if left out, 1, or as many as `accuracy` needs (at most 24).
        accuracy: expected error from noise and load errors, in tolerances, at which to stop.
        seed: seed of the candidates.

    Raises:
        InputError: a file is missing or wrong, or a number is out of range.
        SingularConfigurationError: the robot is singular in a row.

    Example:
        >>> xd.plan_next("configs/bipod.yaml", "recordings.csv", count=2).totals.round(2).tolist()  # tolerances
        [0.61, 0.54, 0.48]

    Command:
        expdesign next configs/hexapod-h1.yaml recordings.csv --out plan-next.csv --accuracy 0.8
    """
    purpose = purpose_of("next", config, recordings)
    problem = problem_of(config)
    table = table_of(recordings, "recordings")
    measured = correlated(referenced(recordings_from_table(table, problem.loaded.robot), None, problem), problem)
    require_measured(measured, problem.loaded.robot)
    require_readings_of(problem, measured)
    say_unknown_columns(measured)
    found_otherwise = recordings_findings(measured, problem.loaded.robot)
    say([*recorded_findings(measured, problem), *found_otherwise], measured.source)
    fit, undetermined = None, None
    try:
        fit = identified_so_far(problem, measured)
    except NotIdentifiableError as error:
        undetermined = error.message
    degrees = float("inf") if fit is None else fit.noise.degrees
    known = recorded_knowledge(problem, measured, _assumed_loads(problem, table, measured), fit)
    most = count or (1 if accuracy is None else MOST)
    found = next_measurements(problem, known, count=most, accuracy=accuracy, seed=seed)
    frame, rows = _continued(problem, found.decisions, measured), int(fitted_rows(measured).sum())
    decided = tuple(
        informed_decision(problem, each, rows + more, degrees + more * len(measured.axes))
        for more, each in enumerate(found.informed)
    )
    goodness = fit.goodness if fit is not None and problem.found is None else None
    if any(finding.otherwise for finding in found_otherwise):
        decided = tuple(undecided(decision) for decision in decided)
    return NextResult(
        frame, measured, found.before, found.after, goodness, undetermined, decided, accuracy, purpose=purpose
    )


def _assumed_loads(problem: DesignProblem, table: Table, measured: Recordings) -> FloatArray | None:
    """Parameters of the load of every recording, which errors of the load depend on."""
    if not problem.loaded.sources:
        return None
    plan = read_plan(table, problem.loaded, problem.noise)
    loads: FloatArray = plan.loads[np.searchsorted(table.lines, measured.lines)]
    return loads


def _continued(problem: DesignProblem, decisions: FloatArray, measured: Recordings) -> pd.DataFrame:
    """The plan, numbered on from the recordings; every measurement is a series of its own."""
    settable = np.concatenate([problem.settable(row[None, None])[0] for row in decisions])  # keeps the order
    configurations, parameters = problem.space.decode(settable)
    series = np.arange(len(decisions)) + 1 + int(measured.series.max())
    frame = plan_frame(Plan(configurations, parameters, series), problem.loaded, problem.space.tilts)
    frame["sequence"] += int(measured.sequence.max())
    if problem.noise.shared_reference:
        frame[REFERENCE] = reference_names(series)
    return frame
