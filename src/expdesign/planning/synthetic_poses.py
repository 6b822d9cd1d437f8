"""Measured poses as a geometric calibration would give them: the poses of a model, with load errors and noise drawn."""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.models.model_file import Model
from expdesign.chain.readings.reading import MeasuredPose
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import row_data
from expdesign.errors import InputError
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem
from expdesign.planning.synthetic import load_errors, plan_noise, with_errors


def simulated_poses(
    problem: DesignProblem,
    plan: Plan,
    points: LoadedPoints,
    model: Model | None,
    seed: int,
    *,
    noise: bool,
    errors: bool,
) -> FloatArray:
    """Measured poses (m, rad), shape (N, n), noise on the measured axes only; arguments as in `simulated_deflections`.

    Without a model they are the commands, with the deflections of the base model where there are loads.

    Raises:
        InputError: the model is of positions of markers.
    """
    loaded = problem.loaded
    if model is None and problem.found is not None:
        model = problem.found.model
    chain = Chain(loaded.robot, reading=MeasuredPose()) if model is None else _with_poses(model, problem)
    values = chain.start() if model is None else model.values
    none = np.zeros((len(plan), loaded.robot.coordinates.n))
    added = load_errors(loaded, plan, seed) if errors and loaded.regressor.needs_load else none
    order = np.argsort(points.lines, kind="stable")
    poses = chain.predict(row_data(with_errors(points, added), chain.robot), values)[order]
    if noise:
        poses[:, problem.noise.axes] += plan_noise(problem, plan, seed)
    return poses


def _with_poses(model: Model, problem: DesignProblem) -> Chain:
    """The model's chain with a reading of poses; one of deflections has no parameters of the instrument either."""
    chain = model.chain
    if "frames" in chain.reading.record:
        return chain
    if chain.reading.parameters or chain.reading.names:
        what = "a model of positions of markers does not tell what an instrument of poses reads"
        raise InputError(what, where=model.source, remedy="Identify the robot from measured poses or deflections.")
    return Chain(chain.robot, chain.effects, reading=MeasuredPose())
