"""`expdesign simulate`: recordings of a plan as the model gives them, with noise and load errors."""

from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
import typer

from expdesign.arrays import FloatArray
from expdesign.commands.console import note
from expdesign.compensation.prediction import require_regular_points
from expdesign.design.plan import completed, csv_text, read_plan
from expdesign.design.problem import DesignProblem
from expdesign.design.problem_file import read_problem
from expdesign.errors import InputError
from expdesign.files.output import write_file
from expdesign.files.table import read_table
from expdesign.identification.model_file import read_model
from expdesign.identification.synthetic import simulated_deflections
from expdesign.recordings.reader import points_from_table


def command(
    config: Annotated[Path, typer.Argument(help="Run configuration (YAML).")],
    plan: Annotated[Path, typer.Argument(help="Plan (CSV).")],
    out: Annotated[Path, typer.Option(help="File for the recordings.")],
    model: Annotated[
        Path | None, typer.Option(help="Model (YAML) that deflects; the base model with apK if left out.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the noise and the load errors.")] = 1,
    noise: Annotated[bool, typer.Option("--noise/--no-noise", help="With the configuration's noise.")] = True,
    load_errors: Annotated[
        bool, typer.Option("--load-errors/--no-load-errors", help="With the configuration's load errors.")
    ] = True,
) -> None:
    """Simulate the recordings of a plan.

    Example: expdesign simulate configs/hexapod-h1.yaml plan.csv --out recordings.csv --seed 3
    """
    if seed < 0:
        raise InputError(f"{seed} is not a seed", where="--seed", remedy="Use a whole number of at least 0.")
    problem = read_problem(config)
    table = read_table(plan)
    given = read_plan(table, problem.loaded, shared_reference=problem.noise.shared_reference)
    complete = completed(table, given, problem.loaded)
    points = points_from_table(complete, problem.loaded.robot, measured=True)
    require_regular_points(problem.loaded.robot, points)
    identified = None if model is None else read_model(model)
    deflections = simulated_deflections(problem, given, points, identified, seed, noise=noise, errors=load_errors)
    frame = recorded(complete.frame, deflections, problem)
    write_file(out, csv_text(frame))
    note(f"{len(frame)} rows simulated (seed {seed}{'' if noise else ', no noise'})")
    print(out)


def recorded(frame: pd.DataFrame, deflections: FloatArray, problem: DesignProblem) -> pd.DataFrame:
    """The frame with the measured components and their standard deviations filled in; others are taken out."""
    coordinates = problem.loaded.robot.coordinates
    measured = frame.drop(columns=[name for name in (*coordinates.deflection, *coordinates.deviation) if name in frame])
    deviations = np.sqrt(np.diag(problem.noise.covariance))
    for axis in problem.noise.axes:
        measured[coordinates.deflection[axis]] = deflections[:, axis]
    for axis, deviation in zip(problem.noise.axes, deviations, strict=True):
        measured[coordinates.deviation[axis]] = deviation
    return measured
