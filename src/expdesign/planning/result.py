"""The tables of a finished search (file-formats.md, Fronts and plans)."""

from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.chain.instrument.deflection_noise import series_by_pose
from expdesign.chain.instrument.reference_pose import ReferencedNoise
from expdesign.chain.recordings.references import REFERENCE, reference_names
from expdesign.mechanics.elastostatics.regressors.elastostatic import Elastostatic
from expdesign.planning.front import Front
from expdesign.planning.measuring_time import plan_minutes
from expdesign.planning.plan import Plan, plan_columns
from expdesign.planning.problem import DesignProblem
from expdesign.planning.validation_rows import validation_decisions


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


def plan_of(problem: DesignProblem, front: Front, design: int) -> pd.DataFrame:
    """The plan of one design of the front (index from 0) in recordings form."""
    return plan_of_decisions(problem, front.decisions[design])


def planned(problem: DesignProblem, decisions: FloatArray) -> Plan:
    """The plan that decisions (m, g) stand for: the measurements that are taken, by their series."""
    space = problem.space
    taken = space.taken(decisions)
    quantities = space.quantities(decisions)
    configurations, loads = space.split(quantities)
    numbers = space.series(quantities) if problem.noise.shared_reference else None
    series = series_by_pose(configurations[taken])
    if numbers is not None:
        series = np.unique(numbers[taken], return_inverse=True)[1].reshape(-1) + 1
    return Plan(configurations[taken], loads[taken], series)


def plan_of_decisions(problem: DesignProblem, decisions: FloatArray) -> pd.DataFrame:
    """The plan that decisions (m, g) stand for, in recordings form without the measured columns."""
    return pd.DataFrame(_columns(problem, decisions))


def _columns(problem: DesignProblem, decisions: FloatArray) -> dict[str, Any]:
    """The columns of a plan by their names."""
    plan = _with_validation(problem, decisions)
    # Gravity under a tilted base is computed, not set: twelve decimals are far below what criteria show.
    computed = [name in problem.loaded.robot.coordinates.gravity for name in problem.loaded.load.columns]
    shown = replace(plan, loads=np.where(computed, np.round(plan.loads, 12), plan.loads))
    columns: dict[str, Any] = plan_columns(shown, problem.loaded, problem.space.tilts)
    if problem.validation:
        columns["split"] = np.where(np.arange(len(plan)) < len(plan) - problem.validation, "train", "test")
    if problem.noise.shared_reference:
        columns[REFERENCE] = reference_names(plan.series)
    return columns


def design_minutes(problem: DesignProblem, front: Front) -> FloatArray | None:
    """What the plan of each design takes with its rows for validation (min), shape (d,); None without costs."""
    if problem.costs is None or isinstance(problem.noise, ReferencedNoise):
        return None
    referenced = isinstance(problem.loaded.regressor, Elastostatic)
    shared, costs = problem.noise.shared_reference, problem.costs
    plans = [_with_validation(problem, decisions) for decisions in front.decisions]
    return np.array([plan_minutes(plan, costs, referenced=referenced, shared=shared) for plan in plans])


def _with_validation(problem: DesignProblem, decisions: FloatArray) -> Plan:
    plan = planned(problem, decisions)
    if not problem.validation:
        return plan
    further = validation_decisions(problem, decisions[problem.space.taken(decisions)])
    configurations, loads = problem.space.decode(further)
    series = plan.series.max(initial=0) + series_by_pose(configurations)
    return Plan(
        np.concatenate([plan.configurations, configurations]),
        np.concatenate([plan.loads, loads]),
        np.concatenate([plan.series, series]),
    )


def plans_frame(problem: DesignProblem, front: Front) -> pd.DataFrame:
    """`plans.csv`: the plans of all designs, one below the other."""
    plans = [_columns(problem, decisions) for decisions in front.decisions]
    lengths = [len(plan["sequence"]) for plan in plans]
    joined = {name: np.concatenate([plan[name] for plan in plans]) for name in plans[0]}
    return pd.DataFrame({"design": np.repeat(np.arange(1, len(front) + 1), lengths), **joined})
