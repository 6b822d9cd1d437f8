"""`sheet`: a plan as a sheet for the laboratory, which `identify` takes back when it is filled in."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from expdesign.app.api.arguments import named_arguments
from expdesign.app.api.configuration import Config, plan_of, problem_of
from expdesign.app.api.inputs import TableInput, purpose_of
from expdesign.arrays import FloatArray
from expdesign.chain.recordings.recordings import reading_names
from expdesign.errors import InputError
from expdesign.mechanics.loads.load import tilts_of
from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.deflection_noise import ReferencedNoise
from expdesign.planning.laboratory_sheet import Steps, in_plan_order, ordered
from expdesign.planning.plan import Plan, as_set, plan_frame
from expdesign.planning.problem import DesignProblem
from expdesign.planning.schema import CostsSection
from expdesign.report.laboratory_sheet import SheetResult


@named_arguments
def sheet(config: Config, plan: TableInput) -> SheetResult:
    """Write a plan as a laboratory sheet, in the order that saves changes; `identify` reads the filled-in sheet.

    Args:
        config: run configuration (YAML); its `experiment.costs` says in minutes what changes of pose and load take.
        plan: plan (CSV), of any number of rows.

    Raises:
        InputError: a file is missing or wrong, a series mixes poses, or poses are measured between reference poses.

    Command:
        expdesign sheet configs/hexapod-h1.yaml results/mine/plan.csv --out results/sheet --units mm,mrad
    """
    problem = problem_of(config)
    if isinstance(problem.noise, ReferencedNoise):
        what = "with a reference pose every pose stands between references"
        remedy = "`expdesign run` writes them in order (poses.csv), and `expdesign correct` reads that file."
        raise InputError(what, where=f"{problem.source}, experiment.reference_pose", remedy=remedy)
    read = plan_of(plan, problem)
    table, planned, shared = read.table, read.plan, problem.noise.shared_reference
    referenced = problem.loaded.regressor.referenced
    costs = problem.costs or CostsSection()
    stops = as_set(planned, problem.loaded)
    try:
        steps = ordered(stops, costs, referenced=referenced, shared=shared)
    except InputError as error:
        raise InputError(error.what, where=f"{table.source}, column series", remedy=error.remedy) from None
    text = _frame(problem, planned, steps, referenced=referenced, shared=referenced and shared)
    if table.has("split"):
        text.insert(list(text.columns).index("plan_row"), "split", table.frame["split"].to_numpy()[steps.rows])
    before = in_plan_order(stops, referenced=referenced, shared=shared)
    return SheetResult(
        text,
        steps,
        steps.minutes(costs) if costs.known else None,
        before.minutes(costs) if costs.known else None,
        f"Measuring {problem.loaded.robot.name}: {Path(table.source).name}",
        problem.robot_file,
        purpose=purpose_of("sheet", config, plan),
    )


def _frame(problem: DesignProblem, plan: Plan, steps: Steps, *, referenced: bool, shared: bool) -> pd.DataFrame:
    robot, rows = problem.loaded.robot, steps.rows
    count = len(rows)
    stepped = Plan(plan.configurations[rows], plan.loads[rows], plan.series[rows])
    frame = plan_frame(stepped, problem.loaded, with_gravity=True)
    columns: dict[str, Any] = {str(name): cells.to_numpy() for name, cells in frame.items()}
    columns |= _turned(columns, robot)
    for name in {"mass_kg", *robot.coordinates.wrench} & set(columns):
        columns[name] = np.where(steps.reference, 0.0, columns[name])
    stops, before = as_set(plan, problem.loaded), np.append(np.full(len(robot.configuration), np.nan), robot.gravity)
    columns["do"] = [_what(stops, before, steps, index, shared=shared) for index in range(count)]
    columns["plan_row"] = rows + 1
    readings = (
        reading_names(robot.coordinates) if referenced else tuple(f"measured_{n}" for n in robot.coordinates.pose)
    )
    if not referenced:
        columns["kind"] = ["pose"] * count
    columns |= dict.fromkeys((readings[axis] for axis in problem.noise.axes), "")
    deviations = problem.noise.deviations_at(robot.jacobians(plan.configurations[rows]).pose)
    columns |= {robot.coordinates.deviation[axis]: deviations[:, i] for i, axis in enumerate(problem.noise.axes)}
    columns |= {"time_min": "", "temperature_degC": "", "remarks": ""}
    return pd.DataFrame({name: [value] * count if isinstance(value, str) else value for name, value in columns.items()})


def _turned(columns: dict[str, Any], robot: Robot) -> dict[str, FloatArray]:
    """Takes gravity out of the columns, and returns the tilts of the base that turn it, or it again where none do."""
    names = robot.coordinates.gravity
    if names[0] not in columns:
        return {}
    gravities = np.column_stack([columns.pop(name) for name in names])
    tilts = tilts_of(gravities, robot.gravity)
    if tilts is None:
        return dict(zip(names, gravities.T, strict=True))
    return {name: values for name, values in zip(robot.coordinates.tilt, tilts.T, strict=True) if values.any()}


def _what(stops: Plan, before: FloatArray, steps: Steps, index: int, *, shared: bool) -> str:
    """What changes before a step, in words.

    Args:
        stops: as it is set (`as_set`).
        before: what is set before the first step, NaN for its pose.
        steps: in order.
        index: of the step.
        shared: whether a series shares its reference, so that the next one is set anew.
    """
    row, last = steps.rows[index], steps.rows[index - 1] if index else None
    other = last is None or bool(np.any(stops.loads[row] != stops.loads[last])) or bool(steps.reference[index - 1])
    changed = stops.configurations[row] != (before if last is None else stops.configurations[last])
    words = {"tilt the base": ~np.isnan(before), "set the pose": np.isnan(before)}
    moved = [what for what, where in words.items() if changed[where].any()]
    if shared and last is not None and not moved and stops.series[row] != stops.series[last]:
        moved = ["set the pose anew"]
    if not steps.reference[index]:
        return ", ".join(moved + (["load as given"] if other else []) + ["read"])
    off = bool(index) and not steps.reference[index - 1]
    return ", ".join((["load off"] if off else []) + moved + ["read the reference"])
