"""A robot whose true stiffness is not the one in its file, and recordings of it as a laboratory would give them."""

from copy import copy
from dataclasses import replace

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.recordings.reader import recordings_from_table
from expdesign.chain.recordings.recordings import Recordings
from expdesign.errors import InputError
from expdesign.io.output import csv_text
from expdesign.io.table import parse_table
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.planning.plan import Plan, plan_frame
from expdesign.planning.problem import DesignProblem
from research.studies.equilibrium import EquilibriumPlant


def with_stiffness(problem: DesignProblem, stiffness: FloatArray) -> DesignProblem:
    """The same problem of a robot with another stiffness (N/m), shape (n_p,).

    Raises:
        InputError: the robot has another number of actuators.
    """
    loaded = problem.loaded
    if len(stiffness) != len(loaded.robot.stiffness):
        what = f"{len(loaded.robot.stiffness)} stiffnesses are needed, not {len(stiffness)}"
        raise InputError(what, where=problem.source, remedy="Give one for each actuator.")
    robot = copy(loaded.robot)
    robot.stiffness = np.asarray(stiffness, dtype=float)
    changed = LoadedRobot(robot, loaded.load, loaded.sources, loaded.regressor)
    return replace(problem, loaded=changed)


def recorded(true: DesignProblem, plan: Plan, seed: int, *, noise: bool = True) -> Recordings:
    """Recordings of the full equilibrium of the true robot, with noise, as `identify` reads them."""
    robot = true.loaded.robot
    nothing = np.zeros((1, *plan.configurations.shape))
    deflections = EquilibriumPlant(true.loaded, plan).deflections(nothing)[0].copy()
    pose_map = robot.jacobians(plan.configurations).pose
    if noise:
        drawn = true.noise.drawn(plan.series, 1, np.random.default_rng(seed), pose_map)[0]
        deflections[:, true.noise.axes] += drawn
    frame = plan_frame(plan, true.loaded, False)
    deviations = true.noise.deviations_at(pose_map)
    for index, axis in enumerate(true.noise.axes):
        frame[robot.coordinates.deflection[axis]] = deflections[:, axis]
        frame[robot.coordinates.deviation[axis]] = deviations[:, index]
    return recordings_from_table(parse_table(csv_text(frame), "recordings"), robot)
