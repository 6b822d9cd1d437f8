"""Joint coordinates that bring an arm's tip to its target under load.

The command q solves T(q) = T_D, T(q) being the pose that the model predicts for the loaded tip at the command, with the
geometry that was identified, own weight and load, and T_D the target (`arm_targets.py`). Each pass corrects the
remaining twist [e_p, e_o] by the smallest step (in parts of each joint's range) that undoes the error of the position
and, as far as the remaining freedom allows, that of the orientation,

    δq = S·z,   z = A⁺e_p + N·(B·N)⁺·(e_o − B·A⁺e_p),   A = J_p·S, B = J_o·S, N = I − A⁺A,

so that a redundant arm moves as little as it can, and one with too few joints keeps position before orientation.
A model of deflections knows neither geometry nor sag, which cancel from them: T(q) is the nominal pose moved by the
deflection under the load.
"""

from dataclasses import replace

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.models.model_file import Model
from expdesign.chain.readings.position import Frame, TipPose
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.errors import ConvergenceError, SingularConfigurationError
from expdesign.estimation.compensation.arm_targets import ArmTargets, instrument_of
from expdesign.estimation.compensation.prediction import moved
from expdesign.estimation.compensation.target_loads import TargetLoads
from expdesign.mechanics.robots.robot import CONDITION_LIMIT, Robot

TOLERANCE = 1e-12
"""m, rad: change of the remaining error in one pass at which nothing is gained any more."""
ATTAINED = 1e-9
"""m, rad: error below which a target counts as reached."""
_ITERATIONS = 50
_STEP = 0.3
"""rad or m; a larger correction is the sign of a singular arm."""


def joint_commands(model: Model, targets: ArmTargets, loads: TargetLoads) -> FloatArray:
    """Joint coordinates (N, n_q) for N targets that carry some loads.

    Raises:
        ConvergenceError: no command is found.
        SingularConfigurationError: an arm of six or more joints cannot move its tip as the correction demands.
    """
    robot, points = model.chain.robot, targets.points
    joints = len(robot.stiffness)
    scale = np.where(np.isfinite(robot.links.high - robot.links.low), robot.links.high - robot.links.low, 2.0 * np.pi)
    chain, aimed = tip_chain(model, "base"), at_targets(model, targets, "base")
    commands = points.configurations.copy()
    previous = np.full(len(points), np.inf)
    for _ in range(_ITERATIONS):
        reached = loads.motions(chain, model, moved(aimed, commands, robot))
        twist = np.hstack([targets.positions - reached[:, :3], -reached[:, 3:]])
        if not np.isfinite(twist).all():
            row = int(np.argmax(~np.isfinite(twist).all(axis=1)))
            raise ConvergenceError("no command was found: the predicted pose runs away", where=points.where(row))
        residual = np.stack([np.linalg.norm(twist[:, :3], axis=1), np.linalg.norm(twist[:, 3:], axis=1)], axis=1)
        now = residual.max(axis=1)
        if (np.abs(previous - now) <= TOLERANCE).all() or (now <= TOLERANCE).all():
            break
        previous = now
        # Branches stay where they are.
        commands[:, :joints] += _steps(robot, commands, twist, scale[:joints])
        _require_small(robot, points, commands - points.configurations, scale[:joints])
    else:
        what = f"no command was found in {_ITERATIONS} passes"
        raise ConvergenceError(what, where=points.source, remedy="Is the load far beyond what was identified?")
    _require_attained(robot, points, commands, residual)
    return commands


def tip_chain(model: Model, frame: Frame) -> Chain:
    """The model's chain up to the pose of the tip."""
    return Chain(model.chain.robot, model.chain.effects, reading=TipPose(model.chain.reading, frame))


def at_targets(model: Model, targets: ArmTargets, frame: Frame) -> LoadedPoints:
    """The points with the orientations that the tip shall have there, as absolute readings where the model knows such.

    Own weight shows in the pose of a model of positions, and cancels from one of deflections.
    """
    rotations = targets.rotations
    if frame == "instrument":
        rotations = instrument_of(model)[1].T @ rotations
    names = model.chain.reading.names
    marker = np.zeros(len(targets.points), dtype=np.int64) if names else None
    return replace(targets.points, aim=rotations, marker=marker, markers=names)


def _steps(robot: Robot, commands: FloatArray, twist: FloatArray, scale: FloatArray) -> FloatArray:
    """δq (N, n_p) for remaining errors (N, 6)."""
    jacobian = robot.jacobians(commands).forward * scale
    position, orientation = jacobian[:, :3], jacobian[:, 3:]
    inverse = np.linalg.pinv(position, rcond=1.0 / CONDITION_LIMIT)
    first = (inverse @ twist[:, :3, None])[..., 0]
    null = np.eye(len(scale)) - inverse @ position
    rest = twist[:, 3:] - (orientation @ first[..., None])[..., 0]
    within = np.linalg.pinv(orientation @ null, rcond=1.0 / CONDITION_LIMIT)
    second = (null @ (within @ rest[..., None]))[..., 0]
    steps: FloatArray = (first + second) * scale
    return steps


def _require_small(robot: Robot, targets: LoadedPoints, corrections: FloatArray, scale: FloatArray) -> None:
    row, joint = divmod(int(np.argmax(np.abs(corrections))), corrections.shape[1])
    if abs(corrections[row, joint]) > _STEP:
        what = f"{robot.actuators[joint]} would have to be corrected by {corrections[row, joint]:.3g} rad or m"
        condition = float(np.linalg.cond(robot.jacobians(targets.configurations[[row]]).forward[0] * scale))
        if len(scale) >= 6 and condition > CONDITION_LIMIT:
            what = f"the arm is singular or nearly so there (condition number {condition:.3g}): {what}"
            raise SingularConfigurationError(what, where=targets.where(row), remedy="Choose another configuration.")
        raise ConvergenceError(what, where=targets.where(row), remedy="Is the load far beyond what was identified?")


def _require_attained(robot: Robot, targets: LoadedPoints, commands: FloatArray, residual: FloatArray) -> None:
    """Raise where an arm that should reach every pose does not."""
    row = int(np.argmax(residual.max(axis=1)))
    moving = np.abs(robot.jacobians(commands[row]).forward).max(axis=-2) > 0.0  # joints of other tips move none of it
    if moving.sum() < 6 or residual[row].max() <= ATTAINED:
        return
    what = (
        f"the arm is singular or nearly so there: {residual[row, 0]:.3g} m and {residual[row, 1]:.3g} rad of the "
        "deflection cannot be undone"
    )
    raise SingularConfigurationError(what, where=targets.where(row), remedy="Choose another configuration.")
