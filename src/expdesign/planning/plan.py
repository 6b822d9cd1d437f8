"""A plan: the measurements of one design, as a table that a person takes to the laboratory."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.recordings.joint_columns import with_joint_columns
from expdesign.chain.recordings.measured import read_test_rows
from expdesign.chain.recordings.tilted import with_gravity
from expdesign.errors import InputError
from expdesign.io.table import Table
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.planning.deflection_noise import DeflectionNoise, series_by_pose
from expdesign.planning.tips import named_tips


@dataclass(frozen=True)
class Plan:
    """Measurements of one design.

    Attributes:
        configurations: poses or joint coordinates, shape (m, n_q).
        loads: parameters of the load in the order of its `columns`, shape (m, k).
        series: series numbers, shape (m,).
    """

    configurations: FloatArray
    loads: FloatArray
    series: IntArray

    def __len__(self) -> int:
        return len(self.series)


def as_set(plan: Plan, loaded: LoadedRobot) -> Plan:
    """The plan with gravity, which a tilt of the base turns, among what is set with the pose and not with the load."""
    gravity = loaded.load.gravities(plan.loads, loaded.robot.gravity)
    own = plan.loads[:, : len(loaded.load.own)]
    return Plan(np.hstack([plan.configurations, gravity]), own, plan.series)


def plan_frame(plan: Plan, loaded: LoadedRobot, with_gravity: bool) -> pd.DataFrame:
    """The plan in recordings form without the measured columns; tips by name, of a robot that has several."""
    robot, load = loaded.robot, loaded.load
    columns: dict[str, Any] = {"sequence": np.arange(1, len(plan) + 1), "series": plan.series}
    columns.update({name: plan.configurations[:, i] for i, name in enumerate(robot.configuration)})
    columns |= named_tips(robot, plan.configurations)
    for i, name in enumerate(load.columns):
        if with_gravity or name not in robot.coordinates.gravity:
            columns[name] = plan.loads[:, i]
    return pd.DataFrame(columns)


def read_plan(table: Table, loaded: LoadedRobot, noise: DeflectionNoise) -> Plan:
    """The plan in a table in recordings form; measured columns, where there are some, are ignored.

    Raises:
        InputError: a column is missing or a cell is wrong.
    """
    robot, load = loaded.robot, loaded.load
    table = with_gravity(table, robot)
    configurations = with_joint_columns(table, robot).numbers(robot.configuration)
    if loaded.regressor.needs_load and not any(table.has(name) for name in load.columns):
        table.require(load.columns[:1])
    defaults = load.defaults(robot.gravity)
    loads = np.empty((len(table), len(load.columns)))
    for i, name in enumerate(load.columns):
        given = table.has(name) or np.isnan(defaults[i])
        loads[:, i] = table.numbers((name,))[:, 0] if given else defaults[i]
    if not loaded.regressor.needs_load and np.any(loads):
        where = table.where(int(np.flatnonzero(loads.any(axis=1))[0]))
        what = "geometric calibration measures poses without load"
        raise InputError(what, where=where, remedy="Take the load out, or use `experiment.calibration: both`.")
    plan = Plan(configurations, loads, table.integers("series") if table.has("series") else np.arange(len(table)))
    placed = as_set(plan, loaded).configurations
    if not table.has("series"):
        return replace(plan, series=series_by_pose(placed))
    if noise.shared_reference:
        _same_pose_within_series(table, placed, plan.series)
    return plan


def without_validation(plan: Plan, table: Table) -> Plan:
    """The rows of a plan that are fitted: those that its table does not mark `split: test`."""
    if not table.has("split"):
        return plan
    fitted = ~read_test_rows(table)
    if not fitted.any():
        raise table.fault("every row is kept for validation", 0, "split", remedy="Fit some of them.")
    return Plan(plan.configurations[fitted], plan.loads[fitted], plan.series[fitted])


def require_whole_load(table: Table, loaded: LoadedRobot) -> None:
    """Raise an `InputError` where a column of the load is missing, for which recordings would not be read either."""
    load = loaded.load
    if not loaded.regressor.needs_load or not any(table.has(name) for name in load.columns):
        return
    table.require(tuple(name for name in load.columns if name not in loaded.robot.coordinates.gravity))


def completed(table: Table, plan: Plan, loaded: LoadedRobot) -> Table:
    """The table of a plan with every column that recordings need: sequence, series, and loads that were left out."""
    robot, load = loaded.robot, loaded.load
    frame = table.frame.copy()
    if not table.has("series"):
        frame.insert(0, "series", plan.series.astype(str))
    if not table.has("sequence"):
        frame.insert(0, "sequence", np.arange(1, len(frame) + 1).astype(str))
    for index, name in enumerate(load.columns):
        if not table.has(name) and name not in robot.coordinates.gravity:
            frame[name] = [repr(float(value)) for value in plan.loads[:, index]]
    return replace(table, frame=frame)


def _same_pose_within_series(table: Table, placed: FloatArray, series: IntArray) -> None:
    """Raise where rows of one series differ in pose or gravity, (m, n_q + d): they share no unloaded measurement."""
    for number in np.unique(series):
        rows = np.flatnonzero(series == number)
        other = rows[np.any(placed[rows] != placed[rows[0]], axis=1)]
        if other.size:
            what = f"series {number} has measurements at different poses or tilts: they share no unloaded measurement"
            remedy = "Give every pose and tilt a series of its own, or leave `shared_reference` out."
            raise table.fault(what, int(other[0]), "series", remedy=remedy)
