"""The tables of a finished search (file-formats.md, Fronts and plans)."""

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.design.front import Front
from expdesign.design.measuring_time import plan_minutes
from expdesign.design.plan import Plan, plan_frame
from expdesign.design.problem import DesignProblem
from expdesign.design.validation_rows import validation_decisions
from expdesign.elastostatics.regressors.elastostatic import Elastostatic
from expdesign.instrument.deflection_noise import series_by_pose
from expdesign.instrument.reference_pose import ReferencedNoise


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


def plan_of_decisions(problem: DesignProblem, decisions: FloatArray) -> pd.DataFrame:
    """The plan that decisions (m, g) stand for, in recordings form without the measured columns."""
    configurations, loads = problem.space.decode(_with_validation(problem, decisions))
    # Gravity under a tilted base is computed, not set: twelve decimals are far below what criteria show.
    computed = [name in problem.loaded.robot.coordinates.gravity for name in problem.loaded.load.columns]
    plan = Plan(configurations, np.where(computed, np.round(loads, 12), loads), series_by_pose(configurations))
    frame = plan_frame(plan, problem.loaded, problem.space.tilts)
    if problem.validation:
        frame["split"] = np.where(np.arange(len(plan)) < len(decisions), "train", "test")
    return frame


def design_minutes(problem: DesignProblem, front: Front) -> FloatArray | None:
    """What the plan of each design takes with its rows for validation (min), shape (d,); None without costs."""
    if problem.costs is None or isinstance(problem.noise, ReferencedNoise):
        return None
    referenced = isinstance(problem.loaded.regressor, Elastostatic)
    minutes = np.empty(len(front))
    for design, decisions in enumerate(front.decisions):
        configurations, loads = problem.space.decode(_with_validation(problem, decisions))
        plan = Plan(configurations, loads, series_by_pose(configurations))
        shared = problem.noise.shared_reference
        minutes[design] = plan_minutes(plan, problem.costs, referenced=referenced, shared=shared)
    return minutes


def _with_validation(problem: DesignProblem, decisions: FloatArray) -> FloatArray:
    return np.concatenate([decisions, validation_decisions(problem, decisions)]) if problem.validation else decisions


def plans_frame(problem: DesignProblem, front: Front) -> pd.DataFrame:
    """`plans.csv`: the plans of all designs, one below the other."""
    frames = []
    for design in range(len(front)):
        frame = plan_of(problem, front, design)
        frame.insert(0, "design", design + 1)
        frames.append(frame)
    return pd.concat(frames, ignore_index=True)
