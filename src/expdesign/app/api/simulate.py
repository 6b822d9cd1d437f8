"""`simulate`: recordings of a plan as the model gives them, with noise and load errors."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from expdesign.app.api.concealed import with_concealed
from expdesign.app.api.configuration import Config, problem_of
from expdesign.app.api.inputs import TableInput, TruthInput, purpose_of, require_seed, table_of, truth_of
from expdesign.app.api.result import TableResult
from expdesign.arrays import FloatArray
from expdesign.chain.models.model_file import Model, model_of_robot
from expdesign.chain.recordings.columns import REFERENCE
from expdesign.chain.recordings.points import points_from_table
from expdesign.chain.recordings.recordings import measured_names
from expdesign.chain.recordings.references import reference_names
from expdesign.counted import counted
from expdesign.estimation.compensation.prediction import require_history, require_regular_points
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.robots.robot_file import require_same_robot
from expdesign.planning.plan import Plan, completed, read_plan
from expdesign.planning.problem import DesignProblem
from expdesign.planning.synthetic import simulated_deflections, simulated_poses


@dataclass(frozen=True, repr=False)
class SimulationResult(TableResult):
    """Recordings that were not measured.

    Attributes:
        text: the rows as they stand in a file.
        seed: of the noise and the load errors.
        noise: whether there is noise.
    """

    seed: int
    noise: bool

    @property
    def summary(self) -> str:
        """How many rows there are."""
        return f"{counted(len(self.text), 'row')} simulated"

    @property
    def lines(self) -> list[str]:
        """Nothing beside the file."""
        return []

    @property
    def notes(self) -> list[str]:
        """How many rows there are, and of which seed."""
        return [f"{self.summary} (seed {self.seed}{'' if self.noise else ', no noise'})"]


def simulate(
    config: Config,
    plan: TableInput,
    *,
    model: TruthInput | None = None,
    conceal: str | Sequence[str] = (),
    seed: int = 1,
    noise: bool = True,
    load_errors: bool = True,
    other_robot: bool = False,
) -> SimulationResult:
    """Simulate the recordings of a plan.

    Args:
        config: run configuration (YAML).
        plan: plan (CSV), of any number of rows.
        model: model or robot file (YAML) that deflects; the configuration's robot if left out.
        conceal: physics that really deflects and that the base model lacks, e.g. 'leg_backlash at leg 4, 5 um';
            `expdesign physics` lists what there is.
        seed: of the noise and the load errors.
        noise: with the configuration's noise.
        load_errors: with the configuration's load errors.
        other_robot: a model of another geometry than the configuration's is meant.

    Raises:
        InputError: a file is missing or wrong, or the seed is negative.

    Example:
        >>> recordings = xd.simulate("configs/bipod.yaml", "plan.csv", seed=1)
        >>> recordings.frame.columns[6:].tolist()
        ['dx_m', 'dy_m', 'sx_m', 'sy_m']

    Command:
        expdesign simulate configs/hexapod-h1.yaml plan.csv --out recordings.csv --seed 3
    """
    require_seed(seed)
    purpose = purpose_of("simulate", config, plan)
    problem = problem_of(config)
    table = table_of(plan, "plan")
    given = read_plan(table, problem.loaded, problem.noise)
    complete = completed(table, given, problem.loaded)
    points = points_from_table(complete, problem.loaded.robot, measured=True)
    require_regular_points(problem.loaded.robot, points)
    identified = None if model is None else truth_of(model)
    if identified is not None:
        own = problem.loaded.robot
        require_same_robot(identified.chain.robot, identified.source, own, problem.source, confirmed=other_robot)
    if conceal:
        identified = with_concealed(
            _base(problem) if identified is None else identified,
            [conceal] if isinstance(conceal, str) else conceal,
            problem,
        )
        require_history(identified, complete)
    if not problem.loaded.regressor.referenced:
        drawn = simulated_poses(problem, given, points, identified, seed, noise=noise, errors=load_errors)
        return SimulationResult(_measured(complete.frame, drawn, problem, given), seed, noise, purpose=purpose)
    deflections = simulated_deflections(problem, given, points, identified, seed, noise=noise, errors=load_errors)
    pose_map = problem.loaded.robot.jacobians(given.configurations).pose
    frame = _with_references(complete.frame, problem, given)
    text = _recorded(frame, deflections, problem, problem.noise.deviations_at(pose_map))
    return SimulationResult(text, seed, noise, purpose=purpose)


def _with_references(frame: pd.DataFrame, problem: DesignProblem, plan: Plan) -> pd.DataFrame:
    """The frame with the unloaded readings that rows have in common."""
    if not problem.noise.shared_reference:
        return frame.drop(columns=[REFERENCE], errors="ignore")
    return frame.assign(**{REFERENCE: reference_names(plan.series)})


def _base(problem: DesignProblem) -> Model:
    """What deflects where no model is given: the robot of the configuration."""
    if problem.found is not None:
        return problem.found.model
    return model_of_robot(problem.loaded.robot, YamlDocument(problem.source, Path(), {}))


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
