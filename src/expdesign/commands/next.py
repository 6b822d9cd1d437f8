"""`expdesign next`: the measurements that would most improve the accuracy at the targets."""

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from expdesign.api.inputs import problem_of
from expdesign.commands.console import note, note_unknown_columns
from expdesign.design.plan import Plan, csv_text, plan_frame, read_plan
from expdesign.design.sequential import next_measurements
from expdesign.errors import InputError, NotIdentifiableError
from expdesign.files.output import write_file
from expdesign.files.table import read_table
from expdesign.identification.identify import identify
from expdesign.identification.recorded_knowledge import recorded_knowledge
from expdesign.recordings.reader import recordings_from_table, require_measured

MOST = 24
"""Measurements that are added at most in order to reach an accuracy."""
DOUBTFUL = 0.01


def command(
    config: Annotated[Path, typer.Argument(help="Run configuration (YAML).")],
    recordings: Annotated[Path, typer.Argument(help="What was measured so far (CSV).")],
    out: Annotated[Path, typer.Option(help="File for the plan of the next measurements.")],
    count: Annotated[
        int | None, typer.Option(help="How many; 1 if left out, or as many as the accuracy takes.")
    ] = None,
    accuracy: Annotated[
        float | None, typer.Option(help="Expected total error, in tolerances, at which to stop.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the candidates that are drawn.")] = 1,
) -> None:
    """Plan the next measurements, given what was measured.

    Example: expdesign next configs/hexapod-h1.yaml recordings.csv --out plan-next.csv --accuracy 0.8
    """
    if count is not None and count < 1:
        raise InputError(f"{count} is not a number of measurements", where="--count", remedy="Use at least 1.")
    if seed < 0:
        raise InputError(f"{seed} is not a seed", where="--seed", remedy="Use a whole number of at least 0.")
    if accuracy is not None and not 0.0 < accuracy < float("inf"):
        raise InputError(f"{accuracy:g} is not an accuracy", where="--accuracy", remedy="Give tolerances, e.g. 0.8.")
    problem = problem_of(config)
    problem.require_elastostatic("the next measurements can be planned")
    table = read_table(recordings)
    measured = recordings_from_table(table, problem.loaded.robot)
    require_measured(measured, problem.loaded.robot)
    note_unknown_columns(measured)
    loads = None
    if problem.loaded.sources:
        plan = read_plan(table, problem.loaded, shared_reference=problem.noise.shared_reference)
        loads = plan.loads[np.searchsorted(table.lines, measured.lines)]
    try:
        goodness = identify(problem.loaded.robot, measured, shared_reference=problem.noise.shared_reference).goodness
        if goodness.p_value is not None and goodness.p_value < DOUBTFUL:
            note(
                f"the base model does not explain the recordings (p = {goodness.p_value:.2g}): more of them will not "
                "help until `expdesign diagnose` has found why"
            )
    except NotIdentifiableError as error:
        note(f"so far: {error.message}")
    known = recorded_knowledge(problem, measured, loads)
    most = count or (1 if accuracy is None else MOST)
    found = next_measurements(problem, known, count=most, accuracy=accuracy, seed=seed)
    settable = np.concatenate([problem.settable(row[None, None])[0] for row in found.genes])  # keeps the order
    configurations, parameters = problem.space.decode(settable)
    series = np.arange(len(found.genes)) + 1 + int(measured.series.max())
    frame = plan_frame(Plan(configurations, parameters, series), problem.loaded, problem.space.tilts)
    frame["sequence"] += int(measured.sequence.max())
    write_file(out, csv_text(frame))
    wanted = accuracy if accuracy is not None else 1.0
    if found.before <= wanted:
        note(f"already within {wanted:g} tolerances: no further measurement is needed")
    note(f"expected total error now: {_tolerances(found.before)}")
    for index, value in enumerate(found.after):
        note(f"with {index + 1} more: {_tolerances(float(value))}")
    if accuracy is not None and found.after[-1] > accuracy:
        note(f"{len(found.after)} more are not enough for {accuracy:g} tolerances")
    print(out)


def _tolerances(value: float) -> str:
    return f"{value:.4g} tolerances" if np.isfinite(value) else "not determined"
