"""Targets of a run configuration as a table, and what it lets be measured as the range of a calibration."""

import numpy as np
import pandas as pd

from expdesign.chain.models.estimable import Calibrated
from expdesign.chain.recordings.reader import points_from_table
from expdesign.io.output import csv_text
from expdesign.io.table import Table, parse_table
from expdesign.planning.problem import DesignProblem

_SAMPLES = 200
"""Measurements drawn from the design space, whose corners are added."""


def targets_table(problem: DesignProblem) -> Table:
    """The targets with their loads, one row each, numbered as in the configuration."""
    robot, count = problem.loaded.robot, len(problem.targets.configurations)
    columns: dict[str, object] = {"sequence": np.arange(1, count + 1), "series": np.arange(1, count + 1)}
    columns |= {name: problem.targets.configurations[:, i] for i, name in enumerate(robot.configuration)}
    if all(loaded.load.has_mass for loaded, _ in problem.target_loads):
        names = problem.target_loads[0][0].load.columns
        values = np.array([parameters for _, parameters in problem.target_loads])
    else:
        names, values = robot.coordinates.wrench, problem.target_wrenches
    own = dict(zip(robot.coordinates.gravity, robot.gravity, strict=True))
    for i, name in enumerate(names):
        if name not in own or np.any(values[:, i] != own[name]):
            columns[name] = values[:, i]
    return parse_table(csv_text(pd.DataFrame(columns)), f"{problem.source}, targets")


def calibrated_by(problem: DesignProblem) -> Calibrated:
    """The ranges of what a configuration lets be measured."""
    space, robot = problem.space, problem.loaded.robot
    drawn = space.sample(_SAMPLES, np.random.default_rng(0))
    configurations, loads = space.decode(np.concatenate([drawn, np.stack([space.lower, space.upper])]))
    columns = {name: configurations[:, i] for i, name in enumerate(robot.configuration)}
    columns |= {name: loads[:, i] for i, name in enumerate(problem.loaded.load.columns)}
    table = parse_table(csv_text(pd.DataFrame(columns)), problem.source)
    return Calibrated.of(points_from_table(table, robot), robot)
