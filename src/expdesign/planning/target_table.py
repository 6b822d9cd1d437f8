"""The targets of a configuration as the table that `compensate` reads: a row each, numbered as there."""

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.estimation.compensation.target_loads import EXPERIMENT, SAME_AS, own_error_columns
from expdesign.io.output import csv_text
from expdesign.io.table import Table, parse_table
from expdesign.planning.problem import DesignProblem


def target_loads(problem: DesignProblem) -> tuple[tuple[str, ...], FloatArray]:
    """Columns and values (t, k) of the loads at the targets: payloads and gravity, or wrenches where some are these."""
    if all(loaded.load.has_mass for loaded, _ in problem.target_loads):
        values = np.array([parameters for _, parameters in problem.target_loads])
        return problem.target_loads[0][0].load.columns, values
    return problem.loaded.robot.coordinates.wrench, problem.target_wrenches


def targets_table(problem: DesignProblem) -> Table:
    """The targets with their loads, and how well these are known."""
    robot, count = problem.loaded.robot, len(problem.targets.configurations)
    columns: dict[str, object] = {"sequence": np.arange(1, count + 1), "series": np.arange(1, count + 1)}
    columns |= {name: problem.targets.configurations[:, i] for i, name in enumerate(robot.configuration)}
    names, values = target_loads(problem)
    own = dict(zip(robot.coordinates.gravity, robot.gravity, strict=True))
    for i, name in enumerate(names):
        if name not in own or np.any(values[:, i] != own[name]):
            columns[name] = values[:, i]
    loads = problem.own_loads
    if loads is not None and loads.carries.any():
        columns[SAME_AS] = np.where(loads.carries, EXPERIMENT, "")
    if loads is not None and loads.deviations.any():
        stated = np.where(loads.deviations > 0.0, loads.deviations.astype(object), "")
        columns |= dict(zip(own_error_columns(robot.coordinates), stated.T, strict=True))
    return parse_table(csv_text(pd.DataFrame(columns)), f"{problem.source}, targets")
