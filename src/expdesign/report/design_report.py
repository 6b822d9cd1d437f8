"""What `run` returns and its page: the front, and for each design its plan, the robot and the accuracy to expect."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import pandas as pd

from expdesign.assurance.acceptance.decision import Decision
from expdesign.assurance.acceptance.planned import planned_decisions, recommended_acceptance
from expdesign.assurance.model_error.unseen import Unseen
from expdesign.counted import counted
from expdesign.errors import ArgumentError
from expdesign.io.output import csv_text, output_folder, write_file
from expdesign.planning.accuracy_map import AccuracyMap, accuracy_maps
from expdesign.planning.front import Front
from expdesign.planning.problem import DesignProblem
from expdesign.planning.result import design_minutes, pareto_frame, plan_of, planned, plans_frame, protocol_frame
from expdesign.report import error_maps, words
from expdesign.report.acceptance_texts import sentences
from expdesign.report.blocks import (
    Block,
    Buttons,
    DataTable,
    Download,
    KeyFigure,
    KeyFigures,
    Option,
    PageSection,
    Paragraph,
    Selector,
    Sentences,
    SideBySide,
    Subheading,
)
from expdesign.report.design_data import (
    CRITERIA_CAPTION,
    PlanDeviations,
    design_data,
    design_summary,
    further_criteria,
)
from expdesign.report.design_figures import (
    budget_figure,
    described,
    front_figure,
    plotted,
    shown_criteria,
)
from expdesign.report.design_texts import (
    about_run,
    lower_bound_sentences,
    planned_count,
    poses_text,
    recommendation,
    steps_after,
    vocabulary,
)
from expdesign.report.error_budget import EXPLAINED, acceptance_figure, headings
from expdesign.report.hidden_physics import hidden_section
from expdesign.report.page import Page
from expdesign.report.result import PAGE, FolderResult, PathLike
from expdesign.report.robot_view import view_figure
from expdesign.report.said import Said

_BARS_BESIDE = 12
"""Axes of an error budget that are drawn beside the robot; more take the full width."""

_PLAN_CAPTION = (
    "Plan of design {design}: one row per measurement. Shown in mm, mrad and, of joints, degrees, rounded; the CSV "
    "has the exact values in m and rad, ready to be filled in with what was measured."
)
_BUDGET_CAPTION = (
    "Uncertainty budget and acceptance of design {design}, axis by axis; u are standard uncertainties "
    "(µm and µrad) of the pose attained after compensation, which add in squares."
)


@dataclass(frozen=True, repr=False)
class RunResult(FolderResult):
    """A finished search.

    Attributes:
        problem: what was searched.
        front: what was found.
        written: the content of `run.json` (file-formats.md, run.json).
        unseen: the physics of which the recommended plan hides most; None where all of it shows, or was not looked for.
    """

    FILES: ClassVar = {
        "pareto.csv": "pareto",
        "plans.csv": "plans",
        "plan.csv": "plan",
        "plan-checked.csv": "checked",
        "poses.csv": "protocol",
        "run.json": "record",
        **PAGE,
    }
    problem: DesignProblem
    front: Front
    written: dict[str, Any]
    unseen: Unseen | None = None

    @property
    def said(self) -> Said:
        front, run = self.front, self.written
        best = {name: float(values[front.recommended]) for name, values in front.criteria.items()}
        summary = (
            f"{counted(len(front), 'design')} on the front; recommended design {front.recommended + 1}: "
            f"DUIR {best['duir']:.4g}, FEIR {best['feir']:.4g}, total {best['total']:.4g} tolerances."
        )
        texts = [summary, f"The search ended because {front.ended}.", *recommendation(front)]
        texts += [run["plan_ended"]] if "plan_ended" in run else []
        texts += sentences(recommended_acceptance(self.problem, front))
        texts += [run[name]["sentence"] for name in ("accuracy", "unseen") if name in run]
        return Said(summary, [*texts, *lower_bound_sentences(self.problem, front, run)], document=lambda: run)

    def as_table(self) -> pd.DataFrame:
        """The recommended plan."""
        return self.plan

    @property
    def total(self) -> float:
        """RMS error to expect after compensation with the recommended plan, in tolerances."""
        return float(self.front.criteria["total"][self.front.recommended])

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
        return self.plan_of(self.front.recommended)

    @property
    def checked(self) -> pd.DataFrame | None:
        """The recommended plan with further rows that show what it hides (`plan-checked.csv`); None without any."""
        checked = None if self.unseen is None else self.unseen.checked
        return None if checked is None else plan_of(checked.problem, checked.decisions)

    @property
    def protocol(self) -> pd.DataFrame | None:
        """The poses to measure for `plan` with a reference before each (`poses.csv`); None without a reference."""
        return protocol_frame(self.problem, planned(self.problem, self.front.decisions[self.front.recommended]))

    def plan_of(self, design: int) -> pd.DataFrame:
        """The plan of a design by its row in `pareto`, from 0; the files number designs from 1."""
        if not 0 <= design < len(self.front):
            what = f"there is no design {design}"
            raise ArgumentError(what, argument="design", remedy=f"Designs are 0 to {len(self.front) - 1}.")
        return plan_of(self.problem, self.front.decisions[design])

    def page(self) -> Page:
        problem, front, run = self.problem, self.front, self.written
        assessment = problem.assessed(front.decisions)
        accepted = planned_decisions(problem, assessment)
        maps = accuracy_maps(problem)
        bound = run.get("duir_lower_bound")
        data = design_data(problem, front, assessment, accepted, PlanDeviations(problem, front), maps, bound)
        further = bool(further_criteria(front))
        data["captions"] = {
            "plan": _PLAN_CAPTION,
            "budget-table": _BUDGET_CAPTION,
            "ellipse-table": error_maps.ELLIPSE_CAPTION,
            **({"criteria-table": CRITERIA_CAPTION} if further else {}),
        }
        robot, regressor = problem.loaded.robot, problem.loaded.regressor
        sections = (
            self.said.section("In short", _key_figures(problem, front, accepted[front.recommended]), id="summary"),
            _design(problem, front, accepted[front.recommended], data),
            _choice(problem, front, data),
            _over_workspace(problem, front, data, maps),
            hidden_section(problem, front),
            steps_after(problem),
            vocabulary(front),
            about_run(problem, front, run),
        )
        return Page(
            title=f"Calibration plan for {robot.name}",
            subtitle=(
                f"{robot.kind}, {words.count(planned_count(problem, front), regressor.measurement)}, accuracy wanted "
                f"at {words.count(len(problem.targets.weights), 'target')}; configuration {problem.source}"
            ),
            sections=sections,
            data=data,
            scripts=("robot_view.js", "error_ellipses.js", "accuracy_map.js", "design_report.js"),
            footer=f"Made by expdesign {run.get('versions', {}).get('expdesign', '')}".rstrip() + ".",
        )

    def save_plan(self, folder: PathLike, *, force: bool = False) -> None:
        """Write the plans alone, without what takes longer."""
        with output_folder(Path(folder), self.purpose, force=force) as scratch:
            write_file(scratch / "plan.csv", csv_text(self.plan))
            write_file(scratch / "pareto.csv", csv_text(self.pareto))


def _key_figures(problem: DesignProblem, front: Front, accepted: Decision) -> KeyFigures:
    best = {name: words.number(float(values[front.recommended]), 4) for name, values in front.criteria.items()}
    minutes = design_minutes(problem, front)
    least = front.recommended == front.criteria["total"].argmin()
    why = "least total error" if least else "least total error of those expected to pass"
    figures = [
        KeyFigure("Expected error after calibration", best["total"], "tolerances", "RMS over all axes together"),
        acceptance_figure(accepted),
        KeyFigure("From measurement noise (DUIR)", best["duir"], "tolerances"),
        KeyFigure("From load errors (FEIR)", best["feir"], "tolerances"),
        KeyFigure("Measurements", str(planned_count(problem, front)), "", poses_text(problem, front)),
        KeyFigure("Recommended design", str(front.recommended + 1), f"of {len(front)}", why),
    ]
    if minutes is not None:
        figures.insert(5, KeyFigure("Time of the plan", words.number(float(minutes[front.recommended])), "min"))
    return KeyFigures(figures)


def _choice(problem: DesignProblem, front: Front, data: Mapping[str, Any]) -> PageSection:
    names = shown_criteria(front)
    first = tuple(dict.fromkeys((*front.objectives, "duir", "feir", "total")))
    minutes = design_minutes(problem, front)
    rows = []
    for design in range(len(front)):
        marks = [name for name, index in (("recommended", front.recommended), ("knee", front.knee)) if index == design]
        label = " · ".join((str(design + 1), *marks))
        rows.append([label, *(words.number(float(front.criteria[name][design]), 4) for name in first)])
        if minutes is not None:
            rows[-1].append(words.number(float(minutes[design])))
    titles = ["Design", *(words.criterion_with_unit(name, described(name).unit) for name in first)]
    if minutes is not None:
        titles.append("Cost (min)")
    table = DataTable(
        "designs",
        "Designs on the front. Choose one with the mouse or the arrow keys; its plan appears above. The CSV has all "
        "criteria.",
        titles,
        rows,
        Download("pareto.csv", csv_text(pareto_frame(front, minutes))),
        choice="design",
        chosen=front.recommended,
        tall=True,
    )
    jumps = Buttons((("choose-recommended", "Choose the recommended design"), ("choose-knee", "Choose the knee")))
    figures: list[Block] = [front_figure(front)]
    if data["choosing"]:
        selectors = [
            Selector(id, label, [Option(name, words.criterion(name), name == plotted(front)[k]) for name in names])
            for k, (id, label) in enumerate((("horizontal", "Across"), ("vertical", "Up")))
        ]
        figures = [*selectors, *figures]
    chosen = Paragraph(design_summary(problem, front, front.recommended), id="chosen-text", live=True)
    return PageSection("choice", "Choose another design", (SideBySide(figures, (table, jumps)), chosen))


def _design(problem: DesignProblem, front: Front, accepted: Decision, data: Mapping[str, Any]) -> PageSection:
    first = data["designs"][front.recommended]
    number = str(front.recommended + 1)
    plan = DataTable(
        "plan",
        _PLAN_CAPTION.replace("{design}", number),
        [f"{title} ({unit})" if unit else title for title, unit in data["columns"]],
        first["plan"],
    )
    achieved: list[Block] = [
        Subheading(f"What design {number} achieves", id="accuracy-title"),
        Sentences(first["sentences"], id="accuracy"),
    ]
    bars = budget_figure(accepted.budget)
    wide: list[Block] = []
    (achieved if accepted.budget.matters.sum() <= _BARS_BESIDE else wide).append(bars)
    blocks: list[Block] = [Subheading(f"Plan of design {number}", id="plan-title"), plan]
    if data["view"] is None:
        blocks += [Paragraph(f"There is no picture for a robot of the kind {problem.loaded.robot.kind}."), *achieved]
    else:
        blocks.append(SideBySide(_robot_blocks(problem, data), achieved))
    table = DataTable("budget-table", _BUDGET_CAPTION.replace("{design}", number), headings(accepted), first["budget"])
    exactness = [
        Subheading("How exactly the plan has to be met"),
        Sentences(first["deviationsText"], id="deviations-text"),
    ]
    below = (*wide, table, Paragraph(EXPLAINED), *exactness)
    return PageSection("design", "The plan and what it achieves", (*blocks, *below))


def _over_workspace(
    problem: DesignProblem, front: Front, data: Mapping[str, Any], maps: list[AccuracyMap]
) -> PageSection:
    first, number = data["designs"][front.recommended], str(front.recommended + 1)
    ellipses = error_maps.ellipse_blocks(problem, first["ellipseTable"], number)
    charts = error_maps.map_blocks(problem, maps)
    blocks = [*ellipses, *charts]
    if ellipses and charts:
        *figure, axes = ellipses
        blocks = [SideBySide(figure, charts), axes]
    return PageSection("errors", "In which direction, and elsewhere", blocks)


def _robot_blocks(problem: DesignProblem, data: Mapping[str, Any]) -> list[Block]:
    measurements, dimension = problem.space.measurements, data["view"]["dimension"]
    states = [Option(str(k), f"Measurement {k + 1} of {measurements}", k == 0) for k in range(measurements)]
    states += [Option(f"t{k}", f"Target {k + 1}") for k in range(len(problem.targets.weights))]
    turn = "" if dimension == 2 else " Drag to turn it, scroll to zoom."
    faint = f" Faint: the {data['view']['moving']} in the other measurements." if data["view"]["ghosts"] else ""
    force = ", with the force of the load (red arrow, its length in proportion to the force) where it acts"
    loaded = force if problem.loaded.regressor.needs_load else ""
    caption = f"The robot at the chosen pose, in the base frame{loaded}.{faint}{turn}"
    return [
        view_figure("robot", dimension, "The robot and its load", caption, 420 if dimension == 2 else 500),
        Selector("state", "Show", states, step=True),
        Paragraph("", id="state-text", live=True),
    ]
