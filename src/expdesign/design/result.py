"""The tables of a finished search (file-formats.md, Fronts and plans)."""

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.design.front import Front
from expdesign.design.plan import Plan, plan_frame
from expdesign.design.problem import DesignProblem
from expdesign.instrument.deflection_noise import series_by_pose


def pareto_frame(front: Front) -> pd.DataFrame:
    """`pareto.csv`: every criterion of every design, and which design is recommended."""
    index = np.arange(len(front))
    columns: dict[str, object] = {"design": index + 1}
    columns.update(front.criteria)
    columns["kktpm"] = front.kktpm
    columns["recommended"] = index == front.recommended
    columns["knee"] = index == front.knee
    return pd.DataFrame(columns)


def plan_of(problem: DesignProblem, front: Front, design: int) -> pd.DataFrame:
    """The plan of one design of the front (index from 0) in recordings form."""
    return plan_of_genes(problem, front.genes[design])


def plan_of_genes(problem: DesignProblem, genes: FloatArray) -> pd.DataFrame:
    """The plan that genes (m, g) stand for, in recordings form without the measured columns."""
    configurations, loads = problem.space.decode(genes)
    # Gravity under a tilted base is computed, not set: twelve decimals are far below what criteria show.
    computed = [name in problem.loaded.robot.coordinates.gravity for name in problem.loaded.load.columns]
    plan = Plan(configurations, np.where(computed, np.round(loads, 12), loads), series_by_pose(configurations))
    return plan_frame(plan, problem.loaded, problem.space.tilts)


def plans_frame(problem: DesignProblem, front: Front) -> pd.DataFrame:
    """`plans.csv`: the plans of all designs, one below the other."""
    frames = []
    for design in range(len(front)):
        frame = plan_of(problem, front, design)
        frame.insert(0, "design", design + 1)
        frames.append(frame)
    return pd.concat(frames, ignore_index=True)
