"""What the page of `expdesign run` shows of each design: the data of `design_report.js`."""

from typing import Any

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.assurance.acceptance.said import sentences
from expdesign.io.output import csv_text
from expdesign.planning.accuracy_map import AccuracyMap
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.error_ellipses import target_covariances
from expdesign.planning.front import Front
from expdesign.planning.problem import DesignProblem
from expdesign.planning.result import plans_frame
from expdesign.report import accuracy_map, criteria_table, error_ellipses, words
from expdesign.report.design_figures import criterion_title, hover_text, plotted, shown_criteria
from expdesign.report.deviations import PlanDeviations
from expdesign.report.error_budget import ErrorBudget, acceptance_rows, decision
from expdesign.report.robot_view import levers, robot_states, view_data


def plan_headings(plan: pd.DataFrame) -> list[tuple[str, str]]:
    """Name and unit of the columns of a plan as they are shown."""
    return [(words.plan_column(str(name)).title, words.plan_column(str(name)).unit) for name in plan.columns]


def plan_cells(plan: pd.DataFrame) -> list[list[str]]:
    """Rows of a plan as they are shown: lengths and angles to 0.001 mm and 0.001 mrad (joints: 0.001°)."""
    shown = []
    for name in plan.columns:
        factor = words.plan_column(str(name)).factor
        values = plan[name].to_numpy()
        if values.dtype.kind not in "iuf":
            shown.append([str(value) for value in values])
            continue
        whole = np.issubdtype(values.dtype, np.integer)
        shown.append([str(value) if whole else words.fixed(float(value) * factor, 3) for value in values])
    return [list(row) for row in zip(*shown, strict=True)]


def design_summary(problem: DesignProblem, front: Front, design: int) -> str:
    """One line about a design: its number, what it is, and its criteria."""
    roles = [name for name, index in (("recommended", front.recommended), ("knee", front.knee)) if index == design]
    role = f" ({' and '.join(roles)})" if roles else ""
    values = {name: words.number(front.criteria[name][design]) for name in front.criteria}
    further = [name for name in front.objectives if name not in ("duir", "feir", "total")]
    more = "".join(f"; {words.criterion(name)} {values[name]}" for name in further)
    over = "at the worst target" if problem.targets.aggregate == "max" else "RMS over the targets"
    where = f", {over}" if len(problem.targets.weights) > 1 else ""
    return (
        f"Design {design + 1}{role}: expected error {values['total']} tolerances{where}; "
        f"from measurement noise alone {values['duir']} (DUIR), from load errors alone {values['feir']} (FEIR){more}."
    )


def design_data(
    problem: DesignProblem,
    front: Front,
    assessment: Assessment,
    budget: ErrorBudget,
    deviations: PlanDeviations,
    maps: list[AccuracyMap],
    bound: float | None,
) -> dict[str, Any]:
    """Everything that the page's script needs, for all designs."""
    view, forces = _view(problem, front)
    covariances = target_covariances(assessment)
    compliances = accuracy_map.of_designs(assessment)
    plans = plans_frame(problem, front)
    rows_of = np.split(np.arange(len(plans)), np.flatnonzero(np.diff(plans["design"])) + 1)
    plans = plans.drop(columns="design")
    shown, (heading, *lines) = plan_cells(plans), csv_text(plans).splitlines(keepends=True)
    ellipses = error_ellipses.cells(problem, covariances, budget)
    accepted = [decision(problem, budget, design) for design in range(len(front))]
    designs = []
    for design, (first, last) in enumerate((own[0], own[-1] + 1) for own in rows_of):
        designs.append(
            {
                "number": design + 1,
                "summary": design_summary(problem, front, design),
                "hover": hover_text(front, design),
                "plan": shown[first:last],
                "csv": "".join([heading, *lines[first:last]]),
                "forces": [words.number(force, 4) for force in forces[design]],
                "budget": acceptance_rows(accepted[design]),
                "sigma": _sigma(budget, design),
                "sentences": sentences(accepted[design]),
                "ellipses": error_ellipses.of_design(problem, covariances, design),
                "ellipseTable": ellipses[design],
                "deviationsText": deviations.sentences(design),
                "criteria": criteria_table.cells(front, design),
                "compliance": compliances[design],
            }
        )
    rows = budget.rows()
    names = dict.fromkeys(shown_criteria(front))
    return {
        "designs": designs,
        "recommended": front.recommended,
        "knee": front.knee,
        "objectives": front.objectives if len(front.objectives) > 1 else plotted(front),
        "parallel": len(front.objectives) > 2,
        "criteria": {name: {"values": front.criteria[name], "title": criterion_title(name)} for name in names},
        "columns": plan_headings(plans),
        "budget": {
            "rows": [[target + 1, budget.axes[axis], budget.tolerance[target, axis]] for target, axis in rows],
            "bars": [rows.index(row) for row in budget.rows_that_matter()],
            "sources": [f"{name.replace(' ', '_')}_std" for name in budget.source_names],
        },
        "view": view,
        "ellipses": error_ellipses.view_data(problem, budget),
        "maps": accuracy_map.view_data(problem, maps),
        "targets": [target_text(problem, target) for target in range(len(problem.targets.weights))],
        "bound": bound,
    }


def target_text(problem: DesignProblem, target: int) -> str:
    """A target's pose and load in words."""
    robot = problem.loaded.robot
    columns = [words.plan_column(name) for name in robot.configuration]
    pose = problem.targets.configurations[target]
    places = [
        f"{column.title} {words.fixed(value * column.factor, 3)} {column.unit}" for column, value in zip(columns, pose)
    ]
    wrench = [
        f"{words.plan_column(name).title} {words.number(value, 4)} {words.plan_column(name).unit}"
        for name, value in zip(robot.coordinates.wrench, problem.target_wrenches[target])
        if abs(value) > 1e-9
    ]
    return f"{', '.join(places)}. Load: {', '.join(wrench) or 'none'}."


def _sigma(budget: ErrorBudget, design: int) -> list[list[float]]:
    """Standard deviations of a design per row of its budget: noise, load, total and each source, to four digits."""
    parts = np.stack([budget.noise[design], budget.load[design], budget.total[design]], axis=-1)
    table = np.concatenate([parts, budget.sources[design]], axis=-1)
    return [[float(f"{value:.4g}") for value in table[row]] for row in budget.rows()]


def _view(problem: DesignProblem, front: Front) -> tuple[dict[str, Any] | None, FloatArray]:
    """The picture's data for every measurement of every design and then every target; forces (N) of the former."""
    loaded, targets = problem.loaded, problem.targets
    configurations, loads = problem.space.decode(front.decisions)
    flat, parameters = configurations.reshape(-1, configurations.shape[-1]), loads.reshape(-1, loads.shape[-1])
    wrenches, _ = loaded.wrenches(loaded.robot.jacobians(flat).rotation, parameters)
    translations = loaded.robot.coordinates.translations
    forces = np.linalg.norm(wrenches[:, :translations], axis=-1).reshape(configurations.shape[:2])
    states = robot_states(
        loaded.robot,
        np.concatenate([flat, targets.configurations]),
        np.concatenate([wrenches, problem.target_wrenches]),
        np.concatenate([levers(loaded.load, parameters), target_levers(problem)]),
    )
    return (None if states is None else view_data(loaded.robot, states)), forces


def target_levers(problem: DesignProblem) -> FloatArray:
    """Where the load acts at each target in the platform frame (m), shape (t, d)."""
    coordinates = problem.loaded.robot.coordinates
    levers = np.zeros((len(problem.targets.weights), len(coordinates.gravity)))
    for target, section in enumerate(problem.config["targets"]):
        centre = (section.get("payload") or {}).get("com_m")
        if centre and coordinates.centre_of_mass:
            levers[target] = centre
    return levers
