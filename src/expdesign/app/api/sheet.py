"""`sheet`: a plan as a sheet for the laboratory, which `identify` takes back when it is filled in."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from expdesign.app.api.configuration import Config, plan_of, problem_of
from expdesign.app.api.inputs import TableInput, named_arguments, purpose_of
from expdesign.app.api.result import FolderResult, PathLike, RowsResult
from expdesign.arrays import FloatArray
from expdesign.chain.recordings.recordings import reading_names
from expdesign.errors import InputError
from expdesign.io.excel import workbook
from expdesign.io.output import csv_text
from expdesign.io.tables_in_units import in_units
from expdesign.mechanics.loads.load import tilts_of
from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.deflection_noise import ReferencedNoise
from expdesign.planning.laboratory_sheet import Costs, Steps, in_plan_order, ordered
from expdesign.planning.plan import Plan, as_set, plan_columns
from expdesign.planning.problem import DesignProblem
from expdesign.report.laboratory_sheet import rounded, sheet_instructions, sheet_page, sheet_said
from expdesign.report.said import Said

_FILL = "FFF8DC"


@dataclass(frozen=True, repr=False)
class SheetResult(RowsResult, FolderResult):
    """What is done in the laboratory, with room for what is read.

    Attributes:
        text: one row per step, in order: set-points, load, what to do, and empty cells to be filled in.
        steps: the order and what it takes.
        minutes: time of the steps, or None where the configuration states no costs.
        minutes_in_plan_order: the same for the plan row by row.
        title: of the page.
        shared: whether rows of a series share their reference.
        robot_file: path of the robot's file, for the command that follows; empty where it is not known.
    """

    FILES: ClassVar = dict.fromkeys(("sheet.html", "sheet.csv", "sheet.xlsx"), "files")
    FIRST: ClassVar = "sheet.html"
    steps: Steps
    minutes: float | None
    minutes_in_plan_order: float | None
    title: str
    shared: bool
    robot_file: str = ""

    @property
    def said(self) -> Said:
        return sheet_said(self.steps, self.minutes, self.minutes_in_plan_order)

    @property
    def instructions(self) -> list[str]:
        """What to do with the sheet."""
        return sheet_instructions(self.robot_file)

    def files(self, folder: Path = Path(), units: str | None = None) -> dict[str, Any]:
        """The sheet as a table, as a workbook and as a page for printing."""
        frame = rounded(in_units(self.text, units))
        path = shlex.quote(str(folder / "sheet.xlsx"))
        lines = [line.replace(" sheet.xlsx ", f" {path} ") for line in self.instructions]
        notes = [self.title, self.summary, *lines]
        return {
            "sheet.csv": csv_text(frame),
            "sheet.xlsx": workbook(frame, notes=notes, blank=_FILL),
            "sheet.html": sheet_page(frame, self.title, self.summary, lines),
        }

    def save(self, folder: PathLike, units: str | None = None, *, force: bool = False) -> Path:
        """Write the sheet and return the path of its page.

        Args:
            folder: folder for the results.
            units: units to write, by what they measure, e.g. `mm,mrad`; SI if left out.
            force: replace files that are there for another purpose. A sheet with readings never is.

        Raises:
            InputError: a unit is unknown, or the folder cannot be written.
        """
        return self._write(Path(folder), self.files(Path(folder), units), force=force)


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
    costs = problem.costs or Costs()
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
        shared,
        problem.robot_file,
        purpose=purpose_of("sheet", config, plan),
    )


def _frame(problem: DesignProblem, plan: Plan, steps: Steps, *, referenced: bool, shared: bool) -> pd.DataFrame:
    robot, rows = problem.loaded.robot, steps.rows
    count = len(rows)
    stepped = Plan(plan.configurations[rows], plan.loads[rows], plan.series[rows])
    columns = plan_columns(stepped, problem.loaded, with_gravity=True)
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
