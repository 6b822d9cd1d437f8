"""What recipes need to know of an experiment, and how a size becomes an element."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from research.laboratory.elements.forms import FORMS
from research.laboratory.elements.unlisted import UNLISTED
from research.laboratory.kinematics import leg_directions, leg_lengths

from ..case import UnsuitableError
from ..experiments import Experiment
from ..hidden import Hidden, Sized, element, plain
from ..linear_model import Array, pose_columns, wrenches

CATALOGUE = UNLISTED | FORMS


def hidden(physics: str, low: float, high: float, parameters: Callable[[float], dict[str, Any]]) -> Hidden:
    """Physics whose parameters follow from one size; where it may be found is asked of the element."""
    parts = CATALOGUE[physics](**plain(parameters(low))).parts
    return Hidden(physics, parts, low, high, lambda size: Sized((element(physics, **parameters(size)),)))


def poses(experiment: Experiment) -> Array:
    """Pose coordinates of the rows (m, rad)."""
    return experiment.rows[pose_columns(experiment.machine.robot)].to_numpy(dtype=float)


def positions(experiment: Experiment) -> Array:
    """Position part of the poses, in space (m)."""
    found = poses(experiment)[:, :3]
    return np.column_stack([found, np.zeros((len(found), 3 - found.shape[1]))])


def lengths(experiment: Experiment) -> Array:
    """Commanded leg lengths (m; rows x legs)."""
    robot = experiment.machine.robot
    each = [leg_lengths(robot.base_joints, robot.platform_joints, robot.pose(pose)) for pose in poses(experiment)]
    return np.array(each)


def swivels(experiment: Experiment, leg: int) -> Array:
    """Angle of a leg from its home direction in every row (rad)."""
    robot = experiment.machine.robot

    def direction(pose: Array) -> Array:
        return np.asarray(leg_directions(robot.base_joints, robot.platform_joints, robot.pose(pose))[leg])

    home = direction(np.zeros(poses(experiment).shape[1]))
    return np.array([np.arccos(min(1.0, float(direction(pose) @ home))) for pose in poses(experiment)])


def largest_force(experiment: Experiment) -> float:
    """Largest force of the loads (N)."""
    return float(np.linalg.norm(wrenches(experiment.machine.robot, experiment.rows)[:, :3], axis=1).max())


def moments(experiment: Experiment, on_base: bool = False) -> Array:
    """Moments of the rows (N m): about the origin of P in platform axes, or about that of O."""
    robot = experiment.machine.robot
    loads, here = wrenches(robot, experiment.rows), [robot.pose(pose) for pose in poses(experiment)]
    loads = np.column_stack([loads, np.zeros((len(loads), 6 - loads.shape[1]))]) if robot.planar else loads
    if robot.planar:
        loads = np.column_stack([loads[:, :2], np.zeros((len(loads), 4))])
    if on_base:
        return np.array([w[3:] + np.cross(at.position, w[:3]) for w, at in zip(loads, here, strict=True)])
    return np.array([at.rotation.T @ w[3:] for w, at in zip(loads, here, strict=True)])


def leg_compliance(experiment: Experiment) -> float:
    """Mean of the legs' compliances (m/N)."""
    return float(np.mean(1.0 / experiment.machine.true_stiffness))


def spread(values: Array, least: float) -> float:
    """Range of values that must vary by at least so much."""
    found = float(np.ptp(values))
    if found < least:
        raise UnsuitableError("it varies too little")
    return found


def series_span(experiment: Experiment) -> float:
    """Typical duration of a series (s)."""
    return float(experiment.rows.groupby("series")["time_s"].agg(np.ptp).median())


def horizontal(rng: np.random.Generator, planar: bool) -> Array:
    """A random axis about which a structure tilts under load: horizontal in space, across the plane of a bipod."""
    angle = rng.uniform(0, 2 * np.pi)
    if planar:
        return np.array([0.0, 0.0, float(rng.choice([-1.0, 1.0]))])
    return np.array([np.cos(angle), np.sin(angle), 0.0])
