"""Joint coordinates that bring a serial robot's tip to its target under load.

The command q solves T(q) ⊕ ΔX(q, F) = T(q_D), T(q) being the tip's nominal pose, q_D the coordinates that the target is
given in, and ΔX the motion that the model predicts at the command. Each pass corrects the remaining twist [e_p, e_o] by
the smallest step (in parts of each joint's range) that undoes the error of the position and, as far as the remaining
freedom allows, that of the orientation,

    δq = S·z,   z = A⁺e_p + N·(B·N)⁺·(e_o − B·A⁺e_p),   A = J_p·S, B = J_o·S, N = I − A⁺A,

so that a redundant arm moves as little as it can, and one with too few joints keeps position before orientation.
The target is where the tip of the unloaded robot stands when it is sent to q_D: the sag under the links' own weight is
part of that pose, as it is of every deflection's reference.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.row import row_data
from expdesign.compensation.prediction import moved
from expdesign.errors import ConvergenceError, SingularConfigurationError
from expdesign.recordings.recordings import LoadedPoints
from expdesign.robots.capabilities import Links
from expdesign.robots.orientation import rotation_vector
from expdesign.robots.robot import CONDITION_LIMIT, Robot
from expdesign.symbolic import BatchFunction

TOLERANCE = 1e-12
"""m, rad: change of the remaining error in one pass at which nothing is gained any more."""
ATTAINED = 1e-9
"""m, rad: error below which a target counts as reached."""
_ITERATIONS = 50
_STEP = 0.3
"""rad or m; a larger correction is the sign of a singular arm."""


@dataclass(frozen=True)
class JointCommands:
    """Commands for N targets.

    Attributes:
        commands: joint coordinates, shape (N, n_q).
        residual: remaining error of the tip's position (m) and orientation (rad), shape (N, 2).
        iterations: passes.
    """

    commands: FloatArray
    residual: FloatArray
    iterations: int


def joint_commands(chain: Chain, values: FloatArray, robot: Robot, targets: LoadedPoints) -> JointCommands:
    """Commands for targets whose configurations (N, n_q) are q_D.

    Raises:
        ConvergenceError: no command is found.
        SingularConfigurationError: an arm of six or more joints cannot move its tip as the correction demands.
    """
    wanted = targets.configurations
    links = robot.links
    assert links is not None
    error = _error_function(links, len(robot.configuration))
    joints = len(robot.stiffness)
    scale = np.where(np.isfinite(links.high - links.low), links.high - links.low, 2.0 * np.pi)[:joints]
    commands = wanted.copy()
    previous = np.full(len(wanted), np.inf)
    iterations = 0
    for iteration in range(1, _ITERATIONS + 1):
        deflections = chain.predict(row_data(moved(targets, commands), robot), values)
        iterations = iteration
        (twist,) = error(wanted, commands, deflections)
        if not np.isfinite(twist).all():
            row = int(np.argmax(~np.isfinite(twist).all(axis=1)))
            raise ConvergenceError("no command was found: the predicted pose runs away", where=targets.where(row))
        residual = np.stack([np.linalg.norm(twist[:, :3], axis=1), np.linalg.norm(twist[:, 3:], axis=1)], axis=1)
        now = residual.max(axis=1)
        if (np.abs(previous - now) <= TOLERANCE).all() or (now <= TOLERANCE).all():
            break
        previous = now
        # Branches stay where they are.
        commands[:, :joints] += _steps(robot, commands, twist, scale)
        _require_small(robot, targets, commands - wanted)
    else:
        what = f"no command was found in {_ITERATIONS} passes"
        raise ConvergenceError(what, where=targets.source, remedy="Is the load far beyond what was identified?")
    _require_attained(robot, targets, residual)
    return JointCommands(commands, residual, iterations)


def _error_function(links: Links, count: int) -> BatchFunction:
    """Twist from the loaded tip at a command to the target, as a function of q_D, q and ΔX."""
    wanted, command, deflection = ca.SX.sym("wanted", count), ca.SX.sym("command", count), ca.SX.sym("deflection", 6)
    target, target_rotation = links.tip(wanted)
    position, rotation = links.tip(command)
    turn = rotation_vector(target_rotation @ rotation.T)
    # Deflection and correction are small turns, whose vectors add up to their product's, which is of second order.
    return BatchFunction(
        "tip_error",
        [wanted, command, deflection],
        [ca.vertcat(target - position - deflection[:3], turn - deflection[3:])],
    )


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


def _require_small(robot: Robot, targets: LoadedPoints, corrections: FloatArray) -> None:
    row, joint = divmod(int(np.argmax(np.abs(corrections))), corrections.shape[1])
    if abs(corrections[row, joint]) > _STEP:
        what = f"{robot.actuators[joint]} would have to be corrected by {corrections[row, joint]:.3g} rad or m"
        raise ConvergenceError(what, where=targets.where(row), remedy="Is the load far beyond what was identified?")


def _require_attained(robot: Robot, targets: LoadedPoints, residual: FloatArray) -> None:
    """Raise where an arm that should reach every pose does not."""
    row = int(np.argmax(residual.max(axis=1)))
    if len(robot.stiffness) < 6 or residual[row].max() <= ATTAINED:
        return
    what = (
        f"the arm is singular or nearly so there: {residual[row, 0]:.3g} m and {residual[row, 1]:.3g} rad of the "
        "deflection cannot be undone"
    )
    raise SingularConfigurationError(what, where=targets.where(row), remedy="Choose another configuration.")
