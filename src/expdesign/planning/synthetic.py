"""Recordings as an experiment would give them: the deflections or poses of a model, with load errors and noise drawn at
random.

The loads of the plan are the assumed ones; what acts is the assumed load with the errors of the configuration added to
first order (theory.md 5.2), and what is written down is still the assumed load. Of one seed the weights and the
direction of gravity are the same in every table. A check measurement of targets has the direction of gravity, the
errors of the weights where it carries these, and those of a payload of its own as far as they are stated. Shared errors
that a model has from its own recordings are those of the model, and not drawn.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from expdesign.arrays import FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.models.model_file import Model, model_of_robot
from expdesign.chain.readings.position import MarkerPosition, TipPose
from expdesign.chain.readings.reading import MeasuredPose, Reading
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import row_data
from expdesign.errors import InputError
from expdesign.estimation.acting_loads import ACTING
from expdesign.estimation.compensation.target_loads import TargetLoads
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.loads.errors.source import DirectionError
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem

_LOAD_STREAM, _NOISE_STREAM, _PAYLOAD_STREAM, _CHECK_STREAM = 1, 2, 3, 4


def simulated_readings(
    problem: DesignProblem,
    plan: Plan,
    points: LoadedPoints,
    model: Model | None,
    seed: int,
    *,
    noise: bool,
    errors: bool,
    targets: TargetLoads | None = None,
) -> FloatArray:
    """Deflections of all pose coordinates (m, rad), or poses where these are measured, shape (N, n), noise on the
    measured axes only.

    Args:
        problem: noise, load errors, and the base model with the approximate stiffness.
        plan: the measurements, rows as in the file.
        points: the same rows in the order of their sequence.
        model: what deflects in place of the configuration's robot, or None.
        seed: the same seed gives the same errors of the loads and the same noise, whichever of them is switched off.
        noise: whether there is noise.
        errors: whether the loads have errors.
        targets: what the rows carry, in the order of the file, where these are check measurements; else None.

    Raises:
        InputError: poses are measured, and the model is of positions of markers.
    """
    loaded, model = problem.loaded, truth(problem, model).at_targets
    added: FloatArray = np.zeros((len(plan), loaded.robot.coordinates.n))
    if errors and loaded.regressor.needs_load:
        added = load_errors(loaded, plan, seed, targets, model)
    loads = with_errors(points, added)
    if loaded.regressor.referenced:
        found = _predicted(model.chain, model, loads, targets)
    elif loaded.robot.jointed:
        found = _tip_poses(model, loads, targets)
    else:
        found = _predicted(_with_poses(model), model, loads, targets)
    found = found[np.argsort(points.lines, kind="stable")]
    if noise:
        found[:, problem.noise.axes] += plan_noise(problem, plan, seed, check=targets is not None)
    return found


def plan_noise(problem: DesignProblem, plan: Plan, seed: int, *, check: bool = False) -> FloatArray:
    """Noise of the measured axes (m, rad) of every row of a plan, shape (N, a); a check's is independent of it."""
    pose_map = problem.loaded.robot.jacobians(plan.configurations).pose
    stream = _CHECK_STREAM if check else _NOISE_STREAM
    return problem.noise.drawn(plan.series, 1, np.random.default_rng([seed, stream]), pose_map)[0]


def truth(problem: DesignProblem, model: Model | None) -> Model:
    """What deflects: a model, or the robot of the configuration."""
    if model is None and problem.found is not None:
        model = problem.found.model
    return model or model_of_robot(problem.loaded.robot, YamlDocument(problem.source, Path(), {}))


def load_errors(
    loaded: LoadedRobot, plan: Plan, seed: int, targets: TargetLoads | None = None, model: Model | None = None
) -> FloatArray:
    """Actual minus assumed wrench (N, N·m) of every row, shape (N, n); an unloaded row has no error.

    Shared errors that the chain of a `model` has are not drawn.
    """
    generator = np.random.default_rng([seed, _LOAD_STREAM])
    count, physics = len(plan), set() if model is None else {effect.physics for effect in model.chain.effects}
    carries = np.ones(count, dtype=bool) if targets is None else targets.carries
    acts = []
    for source in loaded.sources:
        everywhere = loaded.load.has_mass and source.source == DirectionError.source and source.shared
        known = source.shared and source.source in ACTING and ACTING[source.source](loaded.robot).physics in physics
        acts.append((carries | everywhere) & (not known))
    errors: FloatArray = loaded.drawn_errors(plan.configurations, plan.loads, 1, generator, acts=acts)[0]
    return errors if targets is None else errors + _own_errors(loaded, plan, seed, targets)


def _own_errors(loaded: LoadedRobot, plan: Plan, seed: int, targets: TargetLoads) -> FloatArray:
    """What errors of the targets' own payloads add to the wrench (N, N·m), shape (N, n); one of rows of one payload."""
    payload = loaded.load.payloads(plan.loads)
    if payload is None or not targets.deviations.any():
        return np.zeros((len(plan), loaded.robot.coordinates.n))
    _, which = np.unique(np.concatenate([payload, targets.deviations], axis=1), axis=0, return_inverse=True)
    drawn = np.random.default_rng([seed, _PAYLOAD_STREAM]).standard_normal((which.max() + 1, payload.shape[1]))
    actual = plan.loads.copy()
    actual[:, : payload.shape[1]] += targets.deviations * drawn[which]
    rotation = loaded.robot.jacobians(plan.configurations).rotation
    added: FloatArray = loaded.load.wrenches(rotation, actual) - loaded.load.wrenches(rotation, plan.loads)
    return added


def _predicted(chain: Chain, model: Model, points: LoadedPoints, targets: TargetLoads | None) -> FloatArray:
    """Readings (N, r) in the order of the sequence, of what the rows carry where they are of targets."""
    if targets is None:
        return chain.predict(row_data(points, chain.robot), model.values)
    carries = np.empty_like(targets.carries)
    carries[np.argsort(points.lines, kind="stable")] = targets.carries
    return replace(targets, carries=carries).motions(chain, model, points)


def with_errors(points: LoadedPoints, added: FloatArray) -> LoadedPoints:
    """Points under their actual loads; errors (N, n) in the order of the file."""
    in_sequence = np.empty_like(added)
    in_sequence[np.argsort(points.lines, kind="stable")] = added
    return replace(points, wrenches=points.wrenches + in_sequence, absolute=points.absolute + in_sequence)


def _tip(identified: Reading) -> TipPose:
    """The reading of a tip's pose in the base's frame; of an absolute one, in which the links' weight shows."""
    if identified.absolute:
        return TipPose(identified)
    return TipPose(MarkerPosition(("tip",), {"tip": np.zeros(3)}, np.zeros(6), np.zeros(0)))


def _tip_poses(model: Model, points: LoadedPoints, targets: TargetLoads | None) -> FloatArray:
    """Poses (N, 6) of the tip of an arm, x ... rz with R = Rz·Ry·Rx, with the sag under the links' weight."""
    chain = Chain(model.chain.robot, model.chain.effects, reading=_tip(model.chain.reading))
    aim = chain.robot.jacobians(points.configurations).rotation
    names = chain.reading.names
    marker = np.zeros(len(points), dtype=np.int64)
    found = _predicted(chain, model, replace(points, aim=aim, marker=marker, markers=names), targets)
    turned = Rotation.from_rotvec(found[:, 3:]).as_matrix() @ aim
    return np.column_stack([found[:, :3], Rotation.from_matrix(turned).as_euler("xyz")])


def _with_poses(model: Model) -> Chain:
    """The model's chain with a reading of poses; one of deflections has no parameters of the instrument either."""
    chain = model.chain
    if "frames" in chain.reading.record:
        return chain
    if chain.reading.parameters or chain.reading.names:
        what = "a model of positions of markers does not tell what an instrument of poses reads"
        raise InputError(what, where=model.source, remedy="Identify the robot from measured poses or deflections.")
    return Chain(chain.robot, chain.effects, reading=MeasuredPose())
