"""What the page of `expdesign run` shows of each design: the data of `design_report.js`.

Among them further criteria beside the best of the front (the observability indices O1 to O5), and how exactly a plan
has to be met, in two sentences.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.assurance.acceptance.decision import Decision
from expdesign.io.output import csv_text
from expdesign.planning.accuracy_map import AccuracyMap
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.error_ellipses import target_covariances
from expdesign.planning.front import Front
from expdesign.planning.optimality.deviations import Deviations, evaluations, plan_deviations
from expdesign.planning.problem import DesignProblem
from expdesign.planning.result import plans_frame
from expdesign.report import error_maps, words
from expdesign.report.acceptance_texts import sentences
from expdesign.report.design_figures import criterion_title, described, hover_text, plotted, shown_criteria
from expdesign.report.error_budget import acceptance_rows, parts
from expdesign.report.robot_section import target_levers, target_text
from expdesign.report.robot_view import levers, robot_states, view_data

DELICATE = 60_000
"""Measurements that are evaluated for the sensitivity of all designs (a second or two); where these are more, of the
recommended one and the knee, of the recommended one, or of none."""
_GROWTH = 0.01
"""Part by which the total error may grow where a plan is not met exactly."""


def deviation_sentences(problem: DesignProblem, front: Front) -> list[list[str]]:
    """For every design, what random deviations from its plan do, where that is worth the time."""
    both = sorted({front.recommended, front.knee})
    number = int(problem.space.taken(front.decisions[both]).sum(axis=1).max())
    each = evaluations(problem, number)
    choices = (list(range(len(front))), both, [front.recommended])
    chosen = next((some for some in choices if each * len(some) <= DELICATE), [])
    if not chosen:
        return [["Not computed for plans of so many measurements, of which each by itself matters little."]] * len(
            front
        )
    found = plan_deviations(problem, front.decisions[chosen])
    only = "the recommended design and the knee" if chosen == both else "the recommended design"
    texts = [[f"Computed for {only} only, because the front or its plans are long."]] * len(front)
    for place, design in enumerate(chosen):
        texts[design] = _deviations(found, place, len(problem.loaded.robot.configuration))
    return texts


def _deviations(found: Deviations, place: int, n_pose: int) -> list[str]:
    """What random deviations do, and which quantity is the most delicate: the error that costs 1 % by itself."""
    if not np.isfinite(found.total[place]):
        return ["This design does not determine every stiffness, so that its sensitivity is not determined either."]
    loads, poses = _stated(found, slice(n_pose, None)), _stated(found, slice(0, n_pose))
    loads = f", and every load by {loads}" if loads else ""
    mean, spread = (float(part[place]) for part in found.growth(found.stated))
    texts = [
        f"If every pose is off at random by {poses}{loads} (standard deviations), "
        f"the error to expect changes by about ±{words.number(100.0 * spread, 2)}\u00a0%"
        + (f" and grows by {words.number(100.0 * mean, 2)}\u00a0% on average." if mean > 0.0 else ".")
    ]
    allowed = found.allowed(_GROWTH)[place]
    measurement, quantity = np.unravel_index(int(np.argmin(allowed / found.stated)), allowed.shape)
    if not np.isfinite(allowed[measurement, quantity]):
        return [*texts, "No single deviation costs 1\u00a0%."]
    column = words.plan_column(found.names[quantity])
    return [
        *texts,
        f"The most delicate is the {column.title} of measurement {measurement + 1}: "
        f"{words.number(float(allowed[measurement, quantity]) * column.factor, 2)}\u00a0{column.unit} off costs "
        "1\u00a0%.",
    ]


def _stated(found: Deviations, part: slice) -> str:
    """Stated deviations of a group of quantities: `0.2 mm and 1 mrad`."""
    texts: dict[str, None] = {}
    for name, value in zip(found.names[part], found.stated[part], strict=True):
        column = words.plan_column(name)
        # Angles stated in radians are no round numbers of degrees.
        texts[f"{words.given(float(f'{value * column.factor:.4g}'))}\u00a0{column.unit}"] = None
    return words.listed(list(texts)) if texts else ""


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
    values = {name: words.number(front.criteria[name][design], 4) for name in front.criteria}
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
    accepted: Sequence[Decision],
    deviations: Sequence[list[str]],
    maps: list[AccuracyMap],
    bound: float | None,
) -> dict[str, Any]:
    """Everything that the page's script needs, for all designs."""
    view, forces = _view(problem, front)
    covariances = target_covariances(assessment)
    noise, load_errors = assessment.parameter_covariance
    plans = plans_frame(problem, front)
    rows_of = np.split(np.arange(len(plans)), np.flatnonzero(np.diff(plans["design"])) + 1)
    plans = plans.drop(columns="design")
    shown, (heading, *lines) = plan_cells(plans), csv_text(plans).splitlines(keepends=True)
    budget = accepted[front.recommended].budget
    ellipses = error_maps.ellipse_cells(problem, covariances, budget.axes)
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
                "sigma": [
                    [float(f"{x:.4g}") for x in row]
                    for row in parts(accepted[design].budget).reshape(budget.matters.size, -1)
                ],
                "sentences": sentences(accepted[design]),
                "ellipses": error_maps.ellipses_of(problem, covariances, design),
                "ellipseTable": ellipses[design],
                "deviationsText": deviations[design],
                "criteria": criteria_cells(front, design),
                "compliance": error_maps.packed(noise[design] + load_errors[design]),
            }
        )
    names = dict.fromkeys(shown_criteria(front))
    return {
        "designs": designs,
        "recommended": front.recommended,
        "knee": front.knee,
        "objectives": front.objectives if len(front.objectives) > 1 else plotted(front),
        "choosing": len(front.objectives) > 2,
        "criteria": {name: {"values": front.criteria[name], "title": criterion_title(name)} for name in names},
        "columns": [(column.title, column.unit) for column in map(words.plan_column, plans.columns)],
        "budget": {
            "rows": [[t + 1, budget.axes[i], budget.tolerance[t, i]] for t, i in np.ndindex(budget.matters.shape)],
            "bars": np.flatnonzero(budget.matters),
            "sources": [f"{words.source(one.name).replace(' ', '_')}_std" for one in budget.contributions[1:]],
        },
        "view": view,
        "ellipses": error_maps.ellipse_views(problem, budget),
        "maps": error_maps.map_views(problem, maps),
        "targets": [target_text(problem, target) for target in range(len(problem.targets.weights))],
        "bound": bound,
    }


def _view(problem: DesignProblem, front: Front) -> tuple[dict[str, Any] | None, FloatArray]:
    """The picture's data for every measurement of every design and then every target; forces (N) of the former."""
    loaded, targets = problem.loaded, problem.targets
    configurations, loads = problem.space.decode(front.decisions)
    flat, parameters = configurations.reshape(-1, configurations.shape[-1]), loads.reshape(-1, loads.shape[-1])
    wrenches = loaded.load.wrenches(loaded.robot.jacobians(flat).rotation, parameters)
    translations = loaded.robot.coordinates.translations
    forces = np.linalg.norm(wrenches[:, :translations], axis=-1).reshape(configurations.shape[:2])
    states = robot_states(
        loaded.robot,
        np.concatenate([flat, targets.configurations]),
        np.concatenate([wrenches, problem.target_wrenches]),
        np.concatenate([levers(loaded.load, parameters), target_levers(problem)]),
    )
    return (None if states is None else view_data(loaded.robot, states)), forces


CRITERIA_CAPTION = (
    "Further criteria of design {design}. O1 to O5 are observability indices: how well all stiffnesses are determined, "
    "wherever the targets are. Next to them: the best value on this front, and how near the design comes to it."
)
_FIRST = ("duir", "feir", "total")
"""Criteria that stand in the table of designs."""
CRITERIA_COLUMNS = ("Criterion", "Unit", "Better", "Design", "Best on the front", "Best / design")


def further_criteria(front: Front) -> list[str]:
    """Criteria beside the objectives that tell designs apart: one that is 0 for all of them does not."""
    return [name for name, values in front.criteria.items() if name not in _FIRST and np.any(values != 0.0)]


def criteria_cells(front: Front, design: int) -> list[list[str]]:
    """Rows of the table of one design."""
    rows = []
    for name in further_criteria(front):
        criterion, values = described(name), front.criteria[name]
        value = float(values[design])
        best = float(values.max() if criterion.maximise else values.min())
        smaller, larger = sorted((value, best))
        near = f"{words.number(100.0 * smaller / larger)} %" if larger > 0.0 else "–"
        better = "larger" if criterion.maximise else "smaller"
        unit = "–" if criterion.unit == "1" else criterion.unit
        rows.append([criterion.title, unit, better, words.number(value, 4), words.number(best, 4), near])
    return rows
