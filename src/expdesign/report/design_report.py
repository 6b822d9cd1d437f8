"""What `run` returns and its page: the front, and for each design its plan, the robot and the accuracy to expect."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
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
    Definitions,
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
    framed,
    number_of,
)
from expdesign.report.design_data import (
    CRITERIA_CAPTION,
    CRITERIA_COLUMNS,
    criteria_cells,
    design_data,
    design_summary,
    deviation_sentences,
    further_criteria,
)
from expdesign.report.design_figures import (
    budget_figure,
    described,
    front_figure,
    plotted,
    shown_criteria,
)
from expdesign.report.error_budget import EXPLAINED, acceptance_figure, headings
from expdesign.report.glossary import words_section
from expdesign.report.hidden_physics import hidden_section
from expdesign.report.next_steps import next_steps
from expdesign.report.page import Page
from expdesign.report.result import PAGE, FolderResult, PathLike
from expdesign.report.robot_view import view_figure
from expdesign.report.said import Said

_BARS_BESIDE = 12
"""Axes of an error budget that are drawn beside the robot; more take the full width."""

_DESIGNS_CAPTION = (
    "Designs on the front. Choose one with the mouse or the arrow keys; its plan appears above. The CSV has all "
    "criteria."
)
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
        texts = [summary, f"The search ended because {front.ended}.", *_recommendation(front)]
        texts += [run["plan_ended"]] if "plan_ended" in run else []
        texts += sentences(recommended_acceptance(self.problem, front))
        texts += [run[name]["sentence"] for name in ("accuracy", "unseen") if name in run]
        notes = []
        if self.protocol is not None:
            notes.append("poses.csv has every pose to measure, references included; `expdesign correct` reads it")
        return Said(summary, [*texts, *_lower_bound(self.problem, front, run)], notes, lambda: run)

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
        data = design_data(problem, front, assessment, accepted, deviation_sentences(problem, front), maps, bound)
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
            _steps_after(problem),
            _vocabulary(front),
            _about_run(problem, front, run),
        )
        return Page(
            title=f"Calibration plan for {robot.name}",
            subtitle=(
                f"{robot.kind}, {words.count(_planned_count(problem, front), regressor.measurement)}, accuracy wanted "
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
        KeyFigure("Measurements", str(_planned_count(problem, front)), "", _poses_text(problem, front)),
        KeyFigure("Recommended design", str(front.recommended + 1), f"of {len(front)}", why),
    ]
    if minutes is not None:
        figures.insert(5, KeyFigure("Time of the plan", words.number(float(minutes[front.recommended])), "min"))
    return KeyFigures(figures)


def _choice(problem: DesignProblem, front: Front, data: Mapping[str, Any]) -> PageSection:
    names = shown_criteria(front)
    minutes = design_minutes(problem, front)

    def label(row: Any) -> str:
        return " · ".join([str(row.design), *["recommended"] * row.recommended, *["knee"] * row.knee])

    cells: dict[str, str | Callable[[Any], str]] = {"Design": label}
    for name in dict.fromkeys((*front.objectives, "duir", "feir", "total")):
        cells[words.criterion_with_unit(name, described(name).unit)] = number_of(name, digits=4)
    if minutes is not None:
        cells["Cost (min)"] = number_of("cost_min")
    frame = pareto_frame(front, minutes)
    table = framed("designs", _DESIGNS_CAPTION, frame, cells, tall=True)
    file = Download("pareto.csv", csv_text(frame))
    table = replace(table, csv=file, choice="design", chosen=front.recommended)
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


def _steps_after(problem: DesignProblem) -> PageSection:
    """The way from the plan to a compensated robot, with the commands."""
    files = {"config": problem.source, "robot": problem.robot_file, "model": "identified/model.yaml"}
    regressor = problem.loaded.regressor
    if not regressor.referenced:
        return next_steps("evaluate", "identify poses", noun=regressor.noun, **files)
    columns = ", ".join(problem.loaded.robot.coordinates.deflection)
    names = ("evaluate", "simulate", "sheet", "check", "identify", "diagnose", "compensate")
    return next_steps(*names, columns=columns, **files)


def _vocabulary(front: Front) -> PageSection:
    """The words of the page, for a reader who has not met them."""
    names = ["Deflection", "Tolerance", "RMS, σ", "DUIR", "FEIR", "total"]
    names += ["MEIR"] if "meir" in front.criteria else []
    names += ["O1 to O5"] if {"o1", "o2", "o3", "o4", "o5"} & set(further_criteria(front)) else []
    names += ["O_TP, O_MV"] if any(name.startswith(("o_tp", "o_mv")) for name in front.criteria) else []
    return words_section(*names, "Front", "Recommended", "Knee", "Hypervolume")


def _lower_bound(problem: DesignProblem, front: Front, run: Mapping[str, Any]) -> list[str]:
    """How near the designs come to what no plan can surpass, or why that was not computed."""
    bound = run["duir_lower_bound"]
    if bound is None:
        return [f"No lower bound of DUIR: {run['duir_lower_bound_certified_on']}."]
    if bound <= 0.0:
        return []
    duir = front.criteria["duir"]
    recommended = words.number(100.0 * (duir[front.recommended] / bound - 1.0), 2)
    least = words.number(100.0 * (duir.min() / bound - 1.0), 2)
    measurements = words.count(problem.space.measurements, "measurement")
    texts = [
        f"No plan of {measurements} has an error from measurement noise (DUIR) below {words.number(bound)} tolerances.",
        f"The recommended design is {recommended}\u00a0% above this bound"
        + ("." if least == recommended else f", the best design on the front {least}\u00a0%."),
    ]
    if front.complete and "duir" in front.objectives:
        texts.append("Every design was evaluated: none has a smaller DUIR than the front.")
    elif duir.min() > bound:
        better = words.number(100.0 * (1.0 - bound / duir.min()), 2)
        texts.append(f"A plan with a smaller DUIR, if there is one, is at most {better}\u00a0% better.")
    return [" ".join(texts)]


def _planned_count(problem: DesignProblem, front: Front) -> int:
    """How many measurements the recommended design takes."""
    return int(problem.space.taken(front.decisions[front.recommended]).sum())


def _poses_text(problem: DesignProblem, front: Front) -> str:
    """At how many different poses the recommended design measures."""
    configurations, _ = problem.space.decode(front.decisions[front.recommended])
    poses = words.count(len(np.unique(configurations.round(9), axis=0)), "pose")
    return f"at {poses}" if problem.loaded.regressor.needs_load else f"at {poses}, without load"


def _missing(share: float | None, *, complete: bool) -> str:
    if complete:
        return "none: all designs were evaluated"
    if not share:
        return "not estimated"
    return f"about {words.number(100.0 * share, 2)} % of it (estimate; unknown branches of the front are not included)"


def _about_run(problem: DesignProblem, front: Front, run: Mapping[str, Any]) -> PageSection:
    """How the designs were searched for, and their further criteria."""
    robot, settings = problem.loaded.robot, problem.optimiser
    point = ", ".join(words.number(float(value)) for value in front.reference_point)
    bound, scope = run.get("duir_lower_bound"), run.get("duir_lower_bound_certified_on")
    clauses = [f"{words.sentence(clause)}." for clause in (scope or "").rstrip(".").split("; ")]
    versions = ", ".join(f"{name} {version}" for name, version in run.get("versions", {}).items())
    items = [
        ("Robot", f"{robot.name} ({robot.kind})"),
        *([] if problem.found is None else [("Model of the robot", problem.found.note)]),
        ("Configuration", problem.source),
        ("Objectives", ", ".join(words.criterion(name) for name in front.objectives)),
        ("Search", f"NSGA-II, population {settings.population}, effort {settings.effort}"),
        ("Why it ended", f"{words.sentence(run.get('search_ended', front.ended) or 'not recorded')}."),
        ("Seed", str(run.get("seed", settings.seed))),
        ("Designs evaluated", str(run.get("evaluations", front.evaluations))),
        ("Hypervolume", f"{words.number(front.hypervolume, 4)} with respect to ({point})"),
        ("Missing hypervolume", _missing(run.get("missing_hypervolume"), complete=front.complete)),
        ("Lower bound of DUIR", "not computed" if bound is None else words.number(bound, 4)),
        *([("How it was computed", " ".join(clauses))] if scope else []),
    ]
    if "wall_s" in run:
        items.insert(6, ("Time", f"{words.number(float(run['wall_s']))} s"))
    if "ended_by_hand" in run:
        items.insert(5, ("Ended by hand", f"{run['ended_by_hand']}; the search was not finished"))
    if versions:
        items.append(("Versions", versions))
    caption = CRITERIA_CAPTION.replace("{design}", str(front.recommended + 1))
    cells = criteria_cells(front, front.recommended)
    criteria = [DataTable("criteria-table", caption, CRITERIA_COLUMNS, cells)] if cells else []
    return PageSection("run", "About this run", (Definitions(items), *criteria))


def _recommendation(front: Front) -> list[str]:
    """Why a design is recommended that has not the least total of the front; nothing where it has."""
    total = front.criteria["total"]
    least = int(total.argmin())
    if least == front.recommended or front.passing is None:
        return []
    passing = "is the only one that is" if front.passing == 1 else f"has the least of the {front.passing} that are"
    return [
        f"Design {least + 1} has the least total of all, {words.number(float(total[least]))} tolerances, and is not "
        f"expected to pass: design {front.recommended + 1} {passing}."
    ]
