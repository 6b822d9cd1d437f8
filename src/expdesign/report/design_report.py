"""The page of `expdesign run`: the front, and for each design its plan, the robot and the accuracy to expect."""

from collections.abc import Mapping
from typing import Any

from expdesign.assurance.acceptance.decision import Decision
from expdesign.assurance.acceptance.planned import planned_decisions
from expdesign.io.output import csv_text
from expdesign.planning.accuracy_map import AccuracyMap, accuracy_maps
from expdesign.planning.front import Front
from expdesign.planning.problem import DesignProblem
from expdesign.planning.result import design_minutes, pareto_frame
from expdesign.report import error_maps, words
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
    planned_count,
    poses_text,
    steps_after,
    vocabulary,
)
from expdesign.report.error_budget import EXPLAINED, acceptance_figure, headings
from expdesign.report.hidden_physics import hidden_section
from expdesign.report.page import Page
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


def design_report(problem: DesignProblem, front: Front, run: Mapping[str, Any], said: Said) -> Page:
    """The report of a finished search.

    Args:
        problem: what was searched.
        front: what was found.
        run: the content of `run.json` (file-formats.md, run.json).
        said: what is said of it (`run_said`).
    """
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
    robot = problem.loaded.robot
    sections = (
        said.section("In short", _key_figures(problem, front, accepted[front.recommended]), id="summary"),
        _design(problem, front, accepted[front.recommended], data),
        _choice(problem, front, data),
        _over_workspace(problem, front, data, maps),
        hidden_section(problem, front),
        steps_after(problem),
        vocabulary(front),
        about_run(problem, front, run),
    )
    versions = run.get("versions", {})
    return Page(
        title=f"Calibration plan for {robot.name}",
        subtitle=(
            f"{robot.kind}, {words.count(planned_count(problem, front), problem.loaded.regressor.measurement)}, "
            f"accuracy wanted at {words.count(len(problem.targets.weights), 'target')}; configuration {problem.source}"
        ),
        sections=sections,
        data=data,
        scripts=("robot_view.js", "error_ellipses.js", "accuracy_map.js", "design_report.js"),
        footer=f"Made by expdesign {versions.get('expdesign', '')}".rstrip() + ".",
    )


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
