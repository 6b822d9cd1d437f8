"""`run`: the Pareto front of a configuration."""

import time
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from expdesign.acceptance.decision import acceptance_record
from expdesign.acceptance.recommended import recommended_acceptance
from expdesign.api.inputs import Config, PathLike, problem_of
from expdesign.design.budget_search import search_within_budget
from expdesign.design.front import Front
from expdesign.design.optimality.whole_plans import CriterionBounds, criterion_bounds
from expdesign.design.parts import Executor, one_after_another
from expdesign.design.plan import Plan
from expdesign.design.problem import DesignProblem
from expdesign.design.protocol import protocol_frame
from expdesign.design.record import run_record
from expdesign.design.result import design_minutes, pareto_frame, plan_of, plans_frame
from expdesign.design.search import Follow, Progress, joined
from expdesign.design.second_process import TwoProcesses, second_process_helps
from expdesign.errors import InputError
from expdesign.files.csv_writer import csv_text
from expdesign.files.output import json_text, output_folder, write_file
from expdesign.instrument.deflection_noise import series_by_pose
from expdesign.model_error.record import recommended_accuracy
from expdesign.report.page import Page

Report = Callable[[str, int, int, str], None]
"""Called with the stage (one word), the steps done, the steps in all, and a note on what was reached."""


def silent(title: str, done: int, total: int, note: str) -> None:
    """The report of who does not want one."""


@dataclass(frozen=True)
class Run:
    """A finished search.

    Attributes:
        problem: what was searched.
        front: what was found.
        record: the content of `run.json` (file-formats.md, run.json).
    """

    problem: DesignProblem
    front: Front
    record: dict[str, Any]

    @property
    def pareto(self) -> pd.DataFrame:
        """Every criterion of every design of the front (`pareto.csv`)."""
        return pareto_frame(self.front, design_minutes(self.problem, self.front))

    @property
    def plans(self) -> pd.DataFrame:
        """The plans of all designs, one below the other (`plans.csv`)."""
        return plans_frame(self.problem, self.front)

    @property
    def plan(self) -> pd.DataFrame:
        """The recommended design's plan (`plan.csv`)."""
        return self.plan_of(self.front.recommended + 1)

    @property
    def protocol(self) -> pd.DataFrame | None:
        """The poses to measure for `plan` with a reference before each (`poses.csv`); None without a reference."""
        configurations, loads = self.problem.space.decode(self.front.decisions[self.front.recommended])
        plan = Plan(configurations, loads, series_by_pose(configurations))
        return protocol_frame(self.problem, plan)

    def plan_of(self, design: int) -> pd.DataFrame:
        """The plan of a design by its number in `pareto`, from 1."""
        if not 1 <= design <= len(self.front):
            raise InputError(f"there is no design {design}", remedy=f"Designs are 1 to {len(self.front)}.")
        return plan_of(self.problem, self.front, design - 1)

    def page(self) -> Page:
        """The report."""
        from expdesign.report.design_report import design_report  # noqa: PLC0415 (slow to import)

        return design_report(self.problem, self.front, self.record)

    def files(self) -> dict[str, str]:
        """Names and texts of the files that hold the results, without the report."""
        further = {} if self.protocol is None else {"poses.csv": csv_text(self.protocol)}
        return {
            **further,
            "pareto.csv": csv_text(self.pareto),
            "plans.csv": csv_text(self.plans),
            "plan.csv": csv_text(self.plan),
            "run.json": json_text(self.record),
        }

    def save(self, folder: PathLike) -> Path:
        """Write the files of `expdesign run` into a folder and return the path of the report."""
        from expdesign.report.stored import PAGE, write_report  # noqa: PLC0415 (slow to import)

        with output_folder(Path(folder)) as scratch:
            for name, text in self.files().items():
                write_file(scratch / name, text)
            write_report(scratch, self.page())
        return Path(folder) / PAGE


def run(
    config: Config,
    *,
    report: Report = silent,
    follow: Follow = lambda state: None,
    seconds: float | None = None,
    timed: bool = True,
    workers: int = 1,
) -> Run:
    """Find the Pareto front of a configuration's objectives, and lower bounds of DUIR and of the total error.

    Args:
        config: run configuration.
        report: called with the progress of the search.
        follow: called with the state of the search, its front so far; returns True to end it with what is there.
        seconds: after which the search ends with what is there (the bounds follow); without a limit, the same input
            gives the same front.
        timed: whether the record says how long it took; without that, the same input gives the same bytes.
        workers: number of processes, of which more than two are no use; the results are the same.

    Raises:
        InputError: the configuration is wrong, or leaves nothing to choose; or the search was ended before any plan
            was known.
        InfeasibleError: no pose is within the robot's limits.
        NotIdentifiableError: no design identifies what the targets need.
    """
    problem = problem_of(config)
    if problem.space.decisions == 0:
        what = "every pose and every load is fixed, so that there is nothing to choose"
        remedy = "Give an interval or a list of choices; `expdesign evaluate` judges a plan that is given."
        raise InputError(what, where=f"{problem.source}, experiment", remedy=remedy)
    started = time.perf_counter()

    ended = ""

    def searching(state: Progress) -> bool:
        nonlocal ended
        text = state.note or f"front {len(state.front)}, hypervolume {state.hypervolume:.6g}"
        report("searching", state.generation, state.generations, text)
        late = seconds is not None and time.perf_counter() - started > seconds
        if (follow(state) or late) and not ended:
            ended = f"generation {state.generation} of {state.generations}" + (f", {state.note}" if state.note else "")
        return bool(ended)

    with TwoProcesses() if workers > 1 and second_process_helps() else nullcontext(one_after_another) as executor:
        problem, front = search_within_budget(problem, searching, executor)
        duir, total = _bounds(problem, front, report, executor)
    front = joined(problem, front, [bounds.whole.plan for bounds in (duir, total)])
    record = run_record(problem, front, duir, total)
    record["acceptance"] = acceptance_record(recommended_acceptance(problem, front))
    accuracy = recommended_accuracy(problem, front)
    if accuracy is not None:
        record["accuracy"] = accuracy.record
    minutes = design_minutes(problem, front)
    if minutes is not None:
        record["cost_min"] = float(minutes[front.recommended])
        record["measurements"] = problem.space.measurements
    if ended:
        record["ended_by_hand"] = ended
    if timed:
        record["wall_s"] = time.perf_counter() - started
    return Run(problem, front, record)


def _bounds(
    problem: DesignProblem, front: Front, report: Report, executor: Executor
) -> tuple[CriterionBounds, CriterionBounds]:
    report("bounding", 0, 2, "DUIR and total")
    count = 0

    def done(index: int) -> None:
        nonlocal count
        count += 1
        report("bounding", count, 2, ("DUIR", "total")[index])

    duir, total = executor(problem)(criterion_bounds, [(0.0, front.decisions), (1.0, front.decisions)], done)
    return duir, total
