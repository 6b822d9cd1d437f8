"""The page of `expdesign run`: the front, and for each design its plan, the robot and the accuracy to expect."""

from collections.abc import Mapping
from typing import Any

from expdesign.acceptance.recommended import recommended_acceptance
from expdesign.design.accuracy_map import AccuracyMap, accuracy_maps
from expdesign.design.front import Front
from expdesign.design.problem import DesignProblem
from expdesign.design.result import design_minutes, pareto_frame
from expdesign.files.csv_writer import csv_text
from expdesign.report import accuracy_map, criteria_table, error_ellipses, words
from expdesign.report import deviations as deviations_report
from expdesign.report.acceptance import acceptance_section
from expdesign.report.blocks import (
    Block,
    Buttons,
    DataTable,
    Definitions,
    Download,
    KeyFigure,
    KeyFigures,
    Option,
    Paragraph,
    Section,
    Selector,
    Sentences,
    SideBySide,
    Subheading,
)
from expdesign.report.design_data import design_data, design_summary
from expdesign.report.design_figures import (
    budget_figure,
    described,
    front_figure,
    parallel_figure,
    plotted,
    shown_criteria,
)
from expdesign.report.design_texts import next_steps, vocabulary
from expdesign.report.deviations import PlanDeviations
from expdesign.report.error_budget import ErrorBudget, error_budget, headings, worst_sentence
from expdesign.report.hidden_physics import hidden_section
from expdesign.report.page import Page
from expdesign.report.robot_view import view_figure

_BARS_BESIDE = 12
"""So many axes of the error budget, at most, are drawn beside the robot; more take the full width."""

_PLAN_CAPTION = (
    "Plan of design {design}: one row per measurement. Shown in mm, mrad and, of joints, degrees, rounded; the CSV "
    "has the exact values in m and rad, ready to be filled in with what was measured."
)
_BUDGET_CAPTION = (
    "Error budget of design {design}: standard deviations (σ, µm and µrad) of the pose attained after compensation. "
    "Independent errors add in squares."
)


def design_report(problem: DesignProblem, front: Front, run: Mapping[str, Any]) -> Page:
    """The report of a finished search.

    Args:
        problem: what was searched.
        front: what was found.
        run: the content of `run.json` (file-formats.md, run.json).
    """
    assessment = problem.assess(*problem.space.decode(front.decisions))
    budget = error_budget(problem, assessment)
    deviations = PlanDeviations(problem, front)
    maps = accuracy_maps(problem)
    bound = run.get("duir_lower_bound")
    data = design_data(problem, front, assessment, budget, deviations, maps, bound)
    data["captions"] = {
        "plan": _PLAN_CAPTION,
        "budget-table": _BUDGET_CAPTION,
        "ellipse-table": error_ellipses.CAPTION,
        "deviations": deviations_report.CAPTION,
        "criteria-table": criteria_table.CAPTION,
    }
    robot = problem.loaded.robot
    hidden = hidden_section(problem, front)
    sections = (
        _summary(problem, front, run, budget, deviations),
        _choice(problem, front, data),
        _design(problem, front, budget, data),
        _errors(problem, front, budget, data, maps),
        acceptance_section(recommended_acceptance(problem, front), f"the recommended design ({front.recommended + 1})"),
        Section("exactness", "How exactly the plan has to be met", deviations.blocks(front.recommended)),
        *(() if hidden is None else (hidden,)),
        next_steps(problem, front),
        vocabulary(front),
        _run(problem, front, run),
    )
    versions = run.get("versions", {})
    page = Page(
        title=f"Calibration plan for {robot.name}",
        subtitle=(
            f"{robot.kind}, {words.count(problem.space.measurements, problem.loaded.regressor.measurement)}, "
            f"accuracy wanted at {words.count(len(problem.targets.weights), 'target')}; configuration {problem.source}"
        ),
        sections=sections,
        data=data,
        scripts=("robot_view.js", "error_ellipses.js", "accuracy_map.js", "design_report.js"),
        footer=f"Made by expdesign {versions.get('expdesign', '')}".rstrip() + ".",
    )
    return page


def lower_bound_sentence(problem: DesignProblem, front: Front, run: Mapping[str, Any]) -> str | None:
    """How near the designs come to what no plan can surpass, or None where that was not computed."""
    bound = run.get("duir_lower_bound")
    if bound is None or bound <= 0.0:
        return None
    duir = front.criteria["duir"]
    recommended = 100.0 * (duir[front.recommended] / bound - 1.0)
    least = 100.0 * (duir.min() / bound - 1.0)
    measurements = words.count(problem.space.measurements, "measurement")
    best = f", the best design on the front within {words.number(least, 2)}\u00a0%" if least < recommended else ""
    whole = run.get("whole_plans", {}).get("duir", {})
    proved = ""
    if whole.get("open") is not None and not whole["finished"]:
        proved = (
            f" Whether any plan of whole measurements has a DUIR between the bound and {words.number(duir.min())} is "
            "open."
        )
    if whole.get("finished") and duir.min() <= whole["least_known"] * (1.0 + 1e-9):
        within = words.number(100.0 * max(whole["gap"], 0.001), 2)
        rests = "" if whole["exact"] else " as far as second differences over small boxes of poses can tell"
        proved = f" The design with the least DUIR is the best plan there is, to {within}\u00a0%{rests}."
    return (
        f"No plan of {measurements} can bring the error from measurement noise (DUIR) below {words.number(bound)} "
        f"tolerances; the recommended design is within {words.number(recommended, 2)}\u00a0% of that{best}.{proved}"
    )


def _summary(
    problem: DesignProblem, front: Front, run: Mapping[str, Any], budget: ErrorBudget, deviations: PlanDeviations
) -> Section:
    decision = recommended_acceptance(problem, front)
    best = {name: words.number(float(values[front.recommended])) for name, values in front.criteria.items()}
    figures = (
        KeyFigure("Expected error after calibration", best["total"], "tolerances", "RMS over all axes together"),
        KeyFigure("Acceptance, axis by axis", "passes" if decision.passes else "fails", "", "see Acceptance"),
        KeyFigure("From measurement noise (DUIR)", best["duir"], "tolerances"),
        KeyFigure("From load errors (FEIR)", best["feir"], "tolerances"),
        KeyFigure("Measurements to take", str(problem.space.measurements), "", _each(problem)),
        KeyFigure("Recommended design", str(front.recommended + 1), f"of {len(front)}", "least total error"),
    )
    sentences = [worst_sentence(budget, front.recommended)]
    bound = lower_bound_sentence(problem, front, run)
    if bound is not None:
        sentences.append(bound)
    sentences.append(deviations.sentences(front.recommended)[0])
    opening = (
        "What the recommended design achieves. A tolerance is the error that the configuration accepts on an axis."
    )
    return Section("summary", "In short", (Paragraph(opening), KeyFigures(figures), Sentences(sentences)))


def _choice(problem: DesignProblem, front: Front, data: Mapping[str, Any]) -> Section:
    names = shown_criteria(front)
    first = tuple(dict.fromkeys((*front.objectives, "duir", "feir", "total")))
    minutes = design_minutes(problem, front)
    rows = []
    for design in range(len(front)):
        marks = [name for name, index in (("recommended", front.recommended), ("knee", front.knee)) if index == design]
        label = " · ".join((str(design + 1), *marks))
        rows.append([label, *(words.number(float(front.criteria[name][design])) for name in first)])
        if minutes is not None:
            rows[-1].append(words.number(float(minutes[design])))
    titles = ["Design", *(words.criterion_with_unit(name, described(name).unit) for name in first)]
    if minutes is not None:
        titles.append("Cost (min)")
    table = DataTable(
        "designs",
        "Designs on the front. Choose one with the mouse or the arrow keys; its plan appears below. The CSV has all "
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
    below: list[Block] = []
    if data["parallel"]:
        selectors = [
            Selector(id, label, [Option(name, words.criterion(name), name == plotted(front)[k]) for name in names])
            for k, (id, label) in enumerate((("horizontal", "Across"), ("vertical", "Up")))
        ]
        figures = [*selectors, *figures]
        below.append(parallel_figure(front))
    chosen = Paragraph(design_summary(problem, front, front.recommended), id="chosen-text", live=True)
    return Section("choice", "Choose a design", (SideBySide(figures, (table, jumps)), *below, chosen))


def _design(problem: DesignProblem, front: Front, budget: ErrorBudget, data: Mapping[str, Any]) -> Section:
    first = data["designs"][front.recommended]
    number = str(front.recommended + 1)
    plan = DataTable(
        "plan",
        _PLAN_CAPTION.replace("{design}", number),
        [f"{title} ({unit})" if unit else title for title, unit in data["columns"]],
        first["plan"],
    )
    accuracy: list[Block] = [
        Subheading(f"Accuracy to expect with design {number}", id="accuracy-title"),
        Sentences(first["sentences"], id="accuracy"),
    ]
    bars = budget_figure(budget)
    wide: list[Block] = []
    (accuracy if len(budget.rows_that_matter()) <= _BARS_BESIDE else wide).append(bars)
    blocks: list[Block] = [Subheading(f"Plan of design {number}", id="plan-title"), plan]
    if data["view"] is None:
        blocks += [Paragraph(f"There is no picture for a robot of the kind {problem.loaded.robot.kind}."), *accuracy]
    else:
        blocks.append(SideBySide(_robot_blocks(problem, data), accuracy))
    table = criteria_table.criteria_table(front, front.recommended)
    return Section("design", "The chosen design", (*blocks, *wide, table))


def _errors(
    problem: DesignProblem, front: Front, budget: ErrorBudget, data: Mapping[str, Any], maps: list[AccuracyMap]
) -> Section:
    first, number = data["designs"][front.recommended], str(front.recommended + 1)
    table = DataTable("budget-table", _BUDGET_CAPTION.replace("{design}", number), headings(budget), first["budget"])
    ellipses = error_ellipses.ellipse_blocks(problem, first["ellipseTable"], number)
    charts = accuracy_map.map_blocks(problem, maps)
    if not ellipses or not charts:
        return Section("errors", "Where the error comes from", (table, *ellipses, *charts))
    *figure, axes = ellipses
    return Section("errors", "Where the error comes from", (table, SideBySide(figure, charts), axes))


def _robot_blocks(problem: DesignProblem, data: Mapping[str, Any]) -> list[Block]:
    measurements, dimension = problem.space.measurements, data["view"]["dimension"]
    states = [Option(str(k), f"Measurement {k + 1} of {measurements}", k == 0) for k in range(measurements)]
    states += [Option(f"t{k}", f"Target {k + 1}") for k in range(len(problem.targets.weights))]
    turn = "" if dimension == 2 else " Drag to turn it, scroll to zoom."
    caption = (
        "The robot at the chosen pose, in the base frame, with the force of the load (red arrow, its length in "
        f"proportion to the force) where it acts. Faint: the platform in the other measurements.{turn}"
    )
    return [
        view_figure("robot", dimension, "The robot and its load", caption, 420 if dimension == 2 else 500),
        Selector("state", "Show", states, step=True),
        Paragraph("", id="state-text", live=True),
    ]


def _each(problem: DesignProblem) -> str:
    return "one loaded pose each" if problem.loaded.regressor.needs_load else "one pose without load each"


def _missing(share: float | None) -> str:
    if share is None:
        return "not estimated"
    if share == 0.0:
        return "none: every design there is was looked at"
    return f"about {share:.2%} of it, estimated, beside valleys that no round has met"


def _run(problem: DesignProblem, front: Front, run: Mapping[str, Any]) -> Section:
    robot, settings = problem.loaded.robot, problem.optimiser
    point = ", ".join(words.number(float(value)) for value in front.reference_point)
    bound, scope = run.get("duir_lower_bound"), run.get("duir_lower_bound_certified_on")
    versions = ", ".join(f"{name} {version}" for name, version in run.get("versions", {}).items())
    items = [
        ("Robot", f"{robot.name} ({robot.kind})"),
        *([] if problem.found is None else [("Model of the robot", problem.found.note)]),
        ("Configuration", problem.source),
        ("Objectives", ", ".join(words.criterion(name) for name in front.objectives)),
        ("Search", f"NSGA-II, population {settings.population}, {settings.generations} generations"),
        ("Seed", str(run.get("seed", settings.seed))),
        ("Designs evaluated", str(run.get("evaluations", front.evaluations))),
        ("Hypervolume", f"{words.number(front.hypervolume, 4)} with respect to ({point})"),
        ("Missing hypervolume", _missing(run.get("missing_hypervolume"))),
        (
            "Lower bound of DUIR",
            "not computed" if bound is None else f"{words.number(bound, 4)} ({scope or 'no scope'})",
        ),
    ]
    if "wall_s" in run:
        items.insert(6, ("Time", f"{words.number(float(run['wall_s']))} s"))
    if "ended_by_hand" in run:
        items.insert(5, ("Ended by hand", f"{run['ended_by_hand']}; the search would have gone on"))
    if versions:
        items.append(("Versions", versions))
    return Section("run", "About this run", (Definitions(items),))
