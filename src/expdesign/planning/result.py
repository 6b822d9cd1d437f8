"""The tables and the record of a finished search (file-formats.md, Fronts and plans; run.json).

Rows of a plan that are kept for validation (`split: test`) are far from those that are fitted, and from each other:
chosen by the maximin distance (Johnson, Moore & Ylvisaker, J. Stat. Plan. Inference 26 (1990) 131), greedily,
out of measurements within all limits: each further one is the farthest from all before it, poses and loads alike scaled
to their ranges. Criteria do not see them.
"""

from dataclasses import replace
from importlib.metadata import version
from typing import Any

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.chain.recordings.columns import REFERENCE
from expdesign.chain.recordings.references import reference_names
from expdesign.planning.deflection_noise import ReferencedNoise, series_by_pose
from expdesign.planning.front import Front, farthest
from expdesign.planning.laboratory_sheet import in_plan_order, ordered
from expdesign.planning.optimality.certificate import LowerBound
from expdesign.planning.plan import Plan, as_set, plan_frame
from expdesign.planning.problem import DesignProblem
from expdesign.planning.sampling import reachable_measurements


def pareto_frame(front: Front, minutes: FloatArray | None = None) -> pd.DataFrame:
    """`pareto.csv`: every criterion of every design, which is recommended, and what each takes (`minutes`, (d,))."""
    index = np.arange(len(front))
    columns: dict[str, object] = {"design": index + 1}
    columns.update(front.criteria)
    columns["kktpm"] = front.kktpm
    columns["recommended"] = index == front.recommended
    columns["knee"] = index == front.knee
    if minutes is not None:
        columns["cost_min"] = minutes
    return pd.DataFrame(columns)


def planned(problem: DesignProblem, decisions: FloatArray) -> Plan:
    """The plan that decisions (m, g) stand for: the measurements that are taken, by their series."""
    space = problem.space
    taken = space.taken(decisions)
    quantities = space.quantities(decisions)
    configurations, loads = space.split(quantities)
    numbers = space.series(quantities) if problem.noise.shared_reference else None
    series = series_by_pose(space.placed(quantities)[taken])
    if numbers is not None:
        series = np.unique(numbers[taken], return_inverse=True)[1].reshape(-1) + 1
    return Plan(configurations[taken], loads[taken], series)


def plan_of(problem: DesignProblem, decisions: FloatArray) -> pd.DataFrame:
    """The plan that decisions (m, g) stand for, in recordings form without the measured columns."""
    plan = _with_validation(problem, decisions)
    # Gravity under a tilted base is computed, not set: twelve decimals are far below what criteria show.
    computed = [name in problem.loaded.robot.coordinates.gravity for name in problem.loaded.load.columns]
    shown = replace(plan, loads=np.where(computed, np.round(plan.loads, 12), plan.loads))
    frame = plan_frame(shown, problem.loaded, problem.space.tilts)
    if problem.validation:
        frame["split"] = np.where(np.arange(len(plan)) < len(plan) - problem.validation, "train", "test")
    if problem.noise.shared_reference:
        frame[REFERENCE] = reference_names(plan.series)
    return frame


def design_minutes(problem: DesignProblem, front: Front) -> FloatArray | None:
    """What the plan of each design takes with its rows for validation (min), shape (d,); None without costs."""
    minutes = [minutes_of_plan(problem, decisions) for decisions in front.decisions]
    return None if None in minutes else np.array(minutes, dtype=float)


def minutes_of_plan(problem: DesignProblem, decisions: FloatArray) -> float | None:
    """What the plan of a design (m, g) takes with its rows for validation (min); None without costs."""
    if problem.costs is None or isinstance(problem.noise, ReferencedNoise):
        return None
    plan = as_set(_with_validation(problem, decisions), problem.loaded)
    referenced, shared = problem.loaded.regressor.referenced, problem.noise.shared_reference
    return ordered(plan, problem.costs, referenced=referenced, shared=shared, travel=False).minutes(problem.costs)


def _with_validation(problem: DesignProblem, decisions: FloatArray) -> Plan:
    plan = planned(problem, decisions)
    if not problem.validation:
        return plan
    further = validation_decisions(problem, decisions[problem.space.taken(decisions)])
    quantities = problem.space.quantities(further)
    configurations, loads = problem.space.split(quantities)
    series = plan.series.max(initial=0) + series_by_pose(problem.space.placed(quantities))
    return Plan(
        np.concatenate([plan.configurations, configurations]),
        np.concatenate([plan.loads, loads]),
        np.concatenate([plan.series, series]),
    )


def plans_frame(problem: DesignProblem, front: Front) -> pd.DataFrame:
    """`plans.csv`: the plans of all designs, one below the other."""
    plans = [plan_of(problem, decisions) for decisions in front.decisions]
    found = pd.concat(plans, ignore_index=True)
    found.insert(0, "design", np.repeat(np.arange(1, len(front) + 1), [len(plan) for plan in plans]))
    return found


_POOL = 400


def validation_decisions(problem: DesignProblem, decisions: FloatArray) -> FloatArray:
    """Decisions (v, g) of the rows for validation of a design (m, g); the same design and seed give the same rows."""
    space = problem.space.alone()
    if problem.validation == 0 or space.decisions == 0:
        return (
            np.zeros((0, space.decisions))
            if problem.validation == 0
            else np.repeat(decisions[:1], problem.validation, 0)
        )
    generator = np.random.default_rng([problem.optimiser.seed, 2])
    pool = reachable_measurements(problem, _POOL, generator)
    pool = space.settable(pool[:, None], problem.loaded.robot.limit_excess)[:, 0]
    pool = pool[problem.reachable(pool)]
    return pool[farthest(pool / space.span, decisions / space.span, problem.validation)]


def protocol_frame(problem: DesignProblem, plan: Plan) -> pd.DataFrame | None:
    """Every pose of a plan in the order of measuring, for `expdesign correct` (docs/reference-poses.md).

    Each loaded pose follows the unloaded one at the same command, and every pose follows the reference; with
    interpolation every pair ends with a reference of its own. What is measured is filled in as `measured_x_m …`. None
    where the configuration has no reference pose.
    """
    noise = problem.noise
    if not isinstance(noise, ReferencedNoise):
        return None
    loaded = problem.loaded
    frame = plan_frame(plan, loaded, problem.space.tilts)
    # Without the load its other columns, such as a centre of mass, keep their values and mean nothing.
    effective = [name for name in loaded.load.columns if name == "mass_kg" or name in loaded.robot.coordinates.wrench]
    steps = in_plan_order(plan, referenced=True, shared=noise.shared_reference)
    order: list[tuple[str, int]] = []
    for row, unloaded in zip(steps.rows.tolist(), steps.reference, strict=True):
        order += [("reference", row), ("unloaded" if unloaded else "loaded", row)]
        order += [("reference", row)] if noise.interpolated and not unloaded else []
    rows = frame.iloc[[row for _, row in order]].reset_index(drop=True)
    kinds = np.array([kind for kind, _ in order])
    rows.loc[kinds != "loaded", effective] = 0.0
    rows.loc[kinds == "reference", list(loaded.robot.configuration)] = noise.reference
    rows["sequence"] = np.arange(1, len(rows) + 1)
    if not noise.shared_reference:
        rows["series"] = [row + 1 for _, row in order]
    rows.insert(2, "kind", np.where(kinds == "reference", "reference", "pose"))
    return rows


PACKAGES = ("casadi", "numpy", "pandas", "pymoo", "scipy")
"""On whose versions the numbers depend, beside this one."""


def versions() -> dict[str, str]:
    """The versions of the packages on which the numbers depend."""
    return {name: version(name) for name in ("expdesign", *PACKAGES)}


def run_record(problem: DesignProblem, front: Front, duir: LowerBound, total: LowerBound) -> dict[str, Any]:
    """The content of `run.json` but for the time; `duir` and `total` are bounds of these criteria."""
    record: dict[str, Any] = {
        "config": problem.config,
        "seed": problem.optimiser.seed,
        "versions": versions(),
        "evaluations": front.evaluations,
        "search_ended": front.ended,
        "duir_lower_bound": duir.value,
        "duir_lower_bound_certified_on": duir.certified_on,
        "total_lower_bound": total.value,
        "total_lower_bound_certified_on": total.certified_on,
        "whole_plans": {"duir": _distance(front, "duir", duir), "total": _distance(front, "total", total)},
        "objectives": list(front.objectives),
        "hypervolume": front.hypervolume,
        "missing_hypervolume": front.missing,
        "reference_point": front.reference_point.tolist(),
        "designs": len(front),
        "recommended": front.recommended + 1,
        "knee": front.knee + 1,
    }
    for criterion in problem.further:
        record[criterion.name] = float(front.criteria[criterion.name][front.recommended])
    return record


def _distance(front: Front, name: str, bound: LowerBound) -> dict[str, float | None]:
    """The least value of a criterion on the front, and by which part of its bound it is above it (`open`)."""
    least = float(np.nanmin(front.criteria[name]))
    return {"least_known": least, "open": max(least / bound.value - 1.0, 0.0) if bound.value else None}
