"""`simulate`: recordings of a plan as the model gives them, with noise and load errors."""

from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from expdesign.api.inputs import Config, ModelInput, PathLike, TableInput, numeric, problem_of, table_of, truth_of
from expdesign.api.outputs import save_table
from expdesign.arrays import FloatArray
from expdesign.compensation.prediction import require_regular_points
from expdesign.design.plan import Plan, completed, read_plan
from expdesign.design.problem import DesignProblem
from expdesign.elastostatics.regressors.elastostatic import Elastostatic
from expdesign.errors import InputError
from expdesign.identification.synthetic import simulated_deflections
from expdesign.identification.synthetic_poses import simulated_poses
from expdesign.recordings.measurand import measured_names
from expdesign.recordings.reader import points_from_table


@dataclass(frozen=True)
class Simulated:
    """Recordings that were not measured.

    Attributes:
        text: the rows as they stand in a file.
    """

    text: pd.DataFrame

    @property
    def frame(self) -> pd.DataFrame:
        """The rows with numbers as numbers."""
        return numeric(self.text)

    def save(self, file: PathLike, units: str | None = None) -> Path:
        """Write the recordings into a file, CSV or .xlsx, in SI or in units such as `mm,mrad`."""
        return save_table(file, self.text, units)


def simulate(
    config: Config,
    plan: TableInput,
    *,
    model: ModelInput | None = None,
    seed: int = 1,
    noise: bool = True,
    load_errors: bool = True,
) -> Simulated:
    """Simulate the recordings of a plan.

    Args:
        config: run configuration.
        plan: what is measured.
        model: what deflects, an identified model or a robot file; the configuration's robot if left out.
        seed: of the noise and the load errors.
        noise: whether there is the configuration's noise.
        load_errors: whether there are the configuration's load errors.

    Raises:
        InputError: a file is missing or wrong, or the seed is negative.
    """
    if seed < 0:
        raise InputError(f"{seed} is not a seed", where="--seed", remedy="Use a whole number of at least 0.")
    problem = problem_of(config)
    table = table_of(plan, "plan")
    given = read_plan(table, problem.loaded, shared_reference=problem.noise.shared_reference)
    complete = completed(table, given, problem.loaded)
    points = points_from_table(complete, problem.loaded.robot, measured=True)
    require_regular_points(problem.loaded.robot, points)
    identified = None if model is None else truth_of(model)
    if not isinstance(problem.loaded.regressor, Elastostatic):
        drawn = simulated_poses(problem, given, points, identified, seed, noise=noise, errors=load_errors)
        return Simulated(_measured(complete.frame, drawn, problem, given))
    deflections = simulated_deflections(problem, given, points, identified, seed, noise=noise, errors=load_errors)
    pose_map = problem.loaded.robot.jacobians(given.configurations).pose
    return Simulated(_recorded(complete.frame, deflections, problem, problem.noise.deviations_at(pose_map)))


def _measured(frame: pd.DataFrame, poses: FloatArray, problem: DesignProblem, plan: Plan) -> pd.DataFrame:
    """The frame with measured poses and their standard deviations filled in."""
    coordinates = problem.loaded.robot.coordinates
    names, deviations = measured_names(coordinates), coordinates.deviation
    measured = frame.drop(columns=[name for name in (*names, *deviations, "kind") if name in frame])
    measured["kind"] = "pose"
    spread = problem.noise.deviations_at(problem.loaded.robot.jacobians(plan.configurations).pose)
    for column, axis in enumerate(problem.noise.axes):
        measured[names[axis]] = poses[:, axis]
        measured[deviations[axis]] = spread[..., column]
    return measured


def _recorded(
    frame: pd.DataFrame, deflections: FloatArray, problem: DesignProblem, deviations: FloatArray
) -> pd.DataFrame:
    """The frame with the measured components and their standard deviations filled in; others are taken out."""
    coordinates = problem.loaded.robot.coordinates
    measured = frame.drop(columns=[name for name in (*coordinates.deflection, *coordinates.deviation) if name in frame])
    for axis in problem.noise.axes:
        measured[coordinates.deflection[axis]] = deflections[:, axis]
    for axis, deviation in zip(problem.noise.axes, deviations.T, strict=True):
        measured[coordinates.deviation[axis]] = deviation
    return measured
