"""Commands that reach a target under load (theory.md 4.1).

The command X_C solves X_C + ΔX(X_C, F) = X_D, ΔX being the motion of the platform from the command that the model
predicts there, with all its effects, and with the errors of its geometry where those were identified. The load is the
one that acts where the platform shall be: a payload's wrench is taken at the orientation of the target, not of the
command. The iteration X_C ← X_D − ΔX(X_C) contracts by about ‖ΔX‖ divided by
the size of the robot (1e-4 for micrometres on decimetres), so that a few passes reach rounding.

With an error of the parameters ε the attained pose differs from the target by exactly ΔX(X_C; c) − ΔX(X_C; ĉ), whose
covariance is S·P·Sᵀ, S being taken at the target, and that of the target's own payload (`target_loads`).

Serial robots are corrected in their joints (`joint_space.py`). A body has no actuators: its command is where it would
have to stand unloaded (the counter-displacement, to be made with shims or feet). `corrections_of` says how large the
corrections are, and how well the pose is known that they attain.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.models.estimable import Calibrated, OutsideRange
from expdesign.chain.models.model_file import Model
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.errors import ConvergenceError, InfeasibleError, InputError
from expdesign.estimation.compensation.arm_targets import ArmTargets, of_joints
from expdesign.estimation.compensation.joint_space import at_targets, joint_commands, tip_chain
from expdesign.estimation.compensation.prediction import chain_of, moved
from expdesign.estimation.compensation.target_loads import AttainedUncertainty, TargetLoads
from expdesign.estimation.coverage import STANDARD
from expdesign.mechanics.robots.robot import Robot

TOLERANCE = 1e-13
"""m, rad: largest remaining error of the predicted pose."""
_ANOTHER = "Choose another target."
_ITERATIONS = 100


@dataclass(frozen=True)
class Compensation:
    """Commands for N targets.

    Attributes:
        commands: poses or joint coordinates to command, shape (N, n_q).
        lengths: actuator lengths of the commands (m), shape (N, n_p), or (N, 0) where the
            commands are joint coordinates.
        deviations: standard deviations of the attained poses (m, rad), shape (N, n).
        drawn: the part of `deviations` that no reading of an arm shows, shape (N, n); None of other robots.
    """

    commands: FloatArray
    lengths: FloatArray
    deviations: FloatArray
    drawn: FloatArray | None = None


def compensate(model: Model, targets: LoadedPoints, loads: TargetLoads | None = None) -> Compensation:
    """Commands for targets, whose configurations are where the platform shall be under their loads.

    Args:
        model: the identified robot.
        targets: where the platform shall be.
        loads: what the targets carry; payloads of their own that are known exactly, if left out.

    Raises:
        InputError: the robot is of a kind whose commands are not poses.
        ConvergenceError: no command is found.
        SingularConfigurationError: the robot is singular at a target.
        InfeasibleError: a command is beyond the robot's limits.
    """
    model = model.at_targets
    robot = model.chain.robot
    if robot.jointed:
        return compensate_arm(model, of_joints(robot, targets), loads)
    if not robot.on_legs and not robot.on_support:
        what = f"compensation is for robots that are commanded by a pose, not for a {robot.kind}"
        raise InputError(what, where=model.source, remedy="Use `expdesign predict` for this robot.")
    robot.jacobians(targets.configurations).require_regular(targets.where, _ANOTHER)
    chain = chain_of(model, platform=True, from_command=True)
    loads = loads or TargetLoads.exact(len(targets), robot.coordinates)
    wanted = targets.configurations
    commands = wanted
    for iteration in range(1, _ITERATIONS + 1):
        deflections = loads.motions(chain, model, moved(targets, commands, robot))
        errors = np.abs(commands + deflections - wanted).max(axis=1)
        if not np.isfinite(errors).all():
            raise _not_converged(targets, errors, iteration)
        if errors.max() <= TOLERANCE:
            break
        commands = wanted - deflections
    else:
        raise _not_converged(targets, errors, _ITERATIONS)
    robot.jacobians(commands).require_regular(targets.where, _ANOTHER)
    require_within_limits(robot, targets, commands)
    deviations = AttainedUncertainty.at(chain, model, targets, loads).deviations
    return Compensation(commands, robot.actuator_coordinates(commands), deviations)


def compensate_arm(model: Model, targets: ArmTargets, loads: TargetLoads | None = None) -> Compensation:
    """Commands for poses of an arm's tip; deviations are along the axes of the targets' frame. See `compensate`."""
    model = model.at_targets
    robot, points = model.chain.robot, targets.points
    loads = loads or TargetLoads.exact(len(points), robot.coordinates)
    commands = joint_commands(model, targets, loads)
    require_within_limits(robot, points, commands)
    aimed = at_targets(model, targets, targets.frame)
    known = AttainedUncertainty.at(tip_chain(model, targets.frame), model, aimed, loads)
    drawn = np.sqrt((known.drawn**2).sum(axis=-1))
    return Compensation(commands, np.zeros((len(points), 0)), known.deviations, drawn)


def _not_converged(targets: LoadedPoints, errors: FloatArray, iterations: int) -> ConvergenceError:
    row = int(np.argmax(np.where(np.isfinite(errors), errors, np.inf)))
    state = f"is still {errors[row]:.3g} m or rad off" if np.isfinite(errors[row]) else "runs away"
    what = f"no command was found: after {iterations} passes the predicted pose {state}"
    return ConvergenceError(what, where=targets.where(row), remedy="Is the load there far beyond what was identified?")


def require_within_limits(robot: Robot, targets: LoadedPoints, commands: FloatArray) -> None:
    """Raise an `InfeasibleError` that names the first target whose command (N, n_q) is beyond the robot's limits."""
    rows, beyond = robot.beyond_limits(commands)
    if rows.size:
        where = targets.where(int(rows[0]))
        raise InfeasibleError(f"the command would be {beyond}", where=where, remedy="Choose a pose within them.")


@dataclass(frozen=True)
class Corrections:
    """Corrections of N commands, in the order of the targets.

    Attributes:
        translation: by how much the commanded platform or tip is beside the target (m), shape (N,).
        rotation: by what angle it is turned against it (rad), shape (N,); zero where poses have no orientation.
        expanded: U = k·u of the attained pose (m, rad), k = 2 (about 95 %), shape (N, n); infinite where the
            recordings did not determine it.
        beyond: what of each target lies outside of what was calibrated, N tuples.
    """

    translation: FloatArray
    rotation: FloatArray
    expanded: FloatArray
    beyond: tuple[tuple[OutsideRange, ...], ...]


def corrections_of(
    robot: Robot, targets: LoadedPoints, found: Compensation, calibrated: Calibrated | None
) -> Corrections:
    """The corrections that commands make: where the unloaded, nominal robot would stand, against the target."""
    there, wanted = found.commands, targets.configurations
    translation = np.linalg.norm(robot.position(there) - robot.position(wanted), axis=-1)
    turned = robot.jacobians(there).rotation - robot.jacobians(wanted).rotation
    # ‖R₁ − R₂‖_F = 2√2·sin(θ/2) keeps small angles exact, which the trace does not.
    chord = np.linalg.norm(turned, axis=(-2, -1)) / (2.0 * np.sqrt(2.0))
    rotation = 2.0 * np.arcsin(np.minimum(chord, 1.0)) * bool(robot.coordinates.rotations)
    beyond = [()] * len(targets) if calibrated is None else calibrated.beyond(targets, robot)
    return Corrections(translation, rotation, STANDARD.factor * found.deviations, tuple(beyond))
