"""`sheet`: a plan as a sheet for the laboratory, which `identify` takes back when it is filled in."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from expdesign.app.api.configuration import Config, problem_of
from expdesign.app.api.inputs import TableInput, named_arguments, purpose_of, table_of
from expdesign.app.api.result import FolderResult, PathLike, RowsResult
from expdesign.chain.recordings.recordings import reading_names
from expdesign.errors import InputError
from expdesign.io.excel import workbook
from expdesign.io.output import csv_text
from expdesign.io.tables_in_units import in_units
from expdesign.planning.deflection_noise import ReferencedNoise
from expdesign.planning.laboratory_sheet import Costs, Steps, in_plan_order, ordered
from expdesign.planning.plan import Plan, plan_columns, read_plan
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
    table = table_of(plan, "plan")
    shared = problem.noise.shared_reference
    planned = read_plan(table, problem.loaded, problem.noise)
    referenced = problem.loaded.regressor.referenced
    costs = problem.costs or Costs()
    try:
        steps = ordered(planned, costs, referenced=referenced, shared=shared)
    except InputError as error:
        raise InputError(error.what, where=f"{table.source}, column series", remedy=error.remedy) from None
    text = _frame(problem, planned, steps, referenced=referenced)
    if table.has("split"):
        text.insert(list(text.columns).index("plan_row"), "split", table.frame["split"].to_numpy()[steps.rows])
    before = in_plan_order(planned, referenced=referenced, shared=shared)
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


def _frame(problem: DesignProblem, plan: Plan, steps: Steps, *, referenced: bool) -> pd.DataFrame:
    robot, rows = problem.loaded.robot, steps.rows
    count = len(rows)
    stepped = Plan(plan.configurations[rows], plan.loads[rows], plan.series[rows])
    columns = plan_columns(stepped, problem.loaded, with_gravity=True)
    for name, own in zip(robot.coordinates.gravity, robot.gravity, strict=True):
        if name in columns and np.all(columns[name] == own):
            del columns[name]
    for name in {"mass_kg", *robot.coordinates.wrench} & set(columns):
        columns[name] = np.where(steps.reference, 0.0, columns[name])
    columns["do"] = [_what(plan, steps, index) for index in range(count)]
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


def _what(plan: Plan, steps: Steps, index: int) -> str:
    """What changes before a step, in words."""
    row = steps.rows[index]
    if index == 0:
        moved, other = True, True
    else:
        last = steps.rows[index - 1]
        moved = bool(np.any(plan.configurations[row] != plan.configurations[last]))
        other = bool(np.any(plan.loads[row] != plan.loads[last])) or bool(steps.reference[index - 1])
    if not steps.reference[index]:
        return ", ".join((["set the pose"] if moved else []) + (["load as given"] if other else []) + ["read"])
    off = bool(index) and not steps.reference[index - 1]
    return ", ".join((["load off"] if off else []) + (["set the pose"] if moved else []) + ["read the reference"])
