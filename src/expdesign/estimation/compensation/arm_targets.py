"""Poses that the tip of an arm shall have, and joint coordinates at which the nominal robot has them.

Targets are Cartesian poses `x_m` ... `rz_rad` (R = Rz·Ry·Rx) in the frame of the base or of the instrument, with joint
columns as the posture to stay near, or joint columns alone: the pose that the nominal robot has there.
"""

from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.models.model_file import Model
from expdesign.chain.readings.position import Frame, MarkerPosition
from expdesign.chain.recordings.joint_columns import with_joint_columns
from expdesign.chain.recordings.points import points_from_table
from expdesign.chain.recordings.recordings import LoadedPoints, in_order
from expdesign.coordinates import SPATIAL
from expdesign.errors import ArgumentError, ConvergenceError
from expdesign.io.table import Table
from expdesign.mechanics.robots.orientation import angles_of_matrix, rotations_of
from expdesign.mechanics.robots.robot import CONDITION_LIMIT, Robot

_ITERATIONS = 200
_LARGEST = 0.3
"""rad or m; largest step of a joint in one pass."""
_STARTS = 30
"""Postures that are tried where none is stated or the stated one leads nowhere."""
_REACHED = 1e-9
"""m, rad."""
_SEED = 0


@dataclass(frozen=True)
class ArmTargets:
    """N targets in the order of their sequence.

    Attributes:
        points: loads, and joint coordinates at which the nominal robot's tip is there.
        positions, rotations: of the tip in the base frame, shapes (N, 3) and (N, 3, 3).
        frame: of the poses: of `stated`, and of what is said of the attained ones.
        stated: the poses in that frame (N, 6).
    """

    points: LoadedPoints
    positions: FloatArray
    rotations: FloatArray
    frame: Frame
    stated: FloatArray


def arm_targets(table: Table, model: Model, frame: Frame) -> ArmTargets:
    """The targets in a table.

    Raises:
        InputError: a column is missing or wrong, or the model knows no instrument.
        ConvergenceError: the nominal robot does not reach a pose.
    """
    robot = model.chain.robot
    table = with_joint_columns(table, robot)
    cartesian = any(table.has(name) for name in SPATIAL.pose[:3])
    if not cartesian:
        found = of_joints(robot, points_from_table(table, robot))
        if frame == "base":
            return found
        place, turn = instrument_of(model)
        stated = poses_of((found.positions - place) @ turn, turn.T @ found.rotations)
        return replace(found, frame=frame, stated=stated)
    joints = robot.configuration[: len(robot.stiffness)]
    posture = any(table.has(name) for name in joints)
    if not posture:
        table = _with_joints(table, robot, np.tile(robot.reference_configuration(), (len(table), 1)))
    table = in_order(table)
    points = points_from_table(table, robot)
    stated = table.numbers(SPATIAL.pose)
    positions, rotations = stated[:, :3], rotations_of(stated[:, 3:])
    if frame == "instrument":
        place, turn = instrument_of(model)
        positions, rotations = positions @ turn.T + place, turn @ rotations
    reached = points.configurations.copy()
    for row in range(len(points)):
        reached[row] = _nominal(robot, positions[row], rotations[row], reached[row], points.where(row))
    # Payloads hang on the tip as it is turned at the target.
    turned = points_from_table(_with_joints(table, robot, reached), robot)
    return ArmTargets(turned, positions, rotations, frame, stated)


def of_joints(robot: Robot, points: LoadedPoints) -> ArmTargets:
    """The poses that the nominal robot has at the joint coordinates of points."""
    positions, rotations = robot.position(points.configurations), robot.jacobians(points.configurations).rotation
    return ArmTargets(points, positions, rotations, "base", poses_of(positions, rotations))


def poses_of(positions: FloatArray, rotations: FloatArray) -> FloatArray:
    """x, y, z (m), rx, ry, rz (rad) of frames (N, 6)."""
    return np.hstack([positions, [angles_of_matrix(rotation) for rotation in rotations]])


def base_as_drawn(model: Model, frame: Frame) -> bool:
    """Whether poses are in a base frame whose turn no reading shows.

    Where the instrument stands was identified, with joint 1's zero as drawn: the two are one rotation.
    """
    reading = model.chain.reading
    return frame == "base" and isinstance(reading, MarkerPosition) and not reading.fixed and reading.instrument is None


def instrument_of(model: Model) -> tuple[FloatArray, FloatArray]:
    """Place (3,) and orientation (3, 3) of the instrument in the base frame; raises an `InputError` without one."""
    reading = model.chain.reading
    if not isinstance(reading, MarkerPosition):
        remedy = "Identify the robot from positions or poses, or give targets in the base frame."
        raise ArgumentError("the model knows no instrument, in whose frame targets could be", argument="frame",
                         remedy=remedy)  # fmt: skip
    chain = model.chain
    if len(reading.standing) > 1:
        what = f"the instrument had {len(reading.standing)} stations, and a target does not say in which it is"
        raise ArgumentError(what, argument="frame", remedy="Give targets in the base frame.")
    frame = model.values[chain.compliances : chain.base][:6] if reading.instrument is None else reading.instrument
    return frame[:3], rotations_of(frame[3:])


def _with_joints(table: Table, robot: Robot, configurations: FloatArray) -> Table:
    joints = robot.configuration[: len(robot.stiffness)]
    cells = {name: [repr(float(x)) for x in configurations[:, i]] for i, name in enumerate(joints)}
    return replace(table, frame=table.frame.assign(**cells))


def _nominal(robot: Robot, position: FloatArray, rotation: FloatArray, posture: FloatArray, where: str) -> FloatArray:
    """Joint coordinates at which the nominal tip has a pose: near the posture, else the nearest to it of several."""
    first = _descend(robot, position, rotation, posture)
    if first is not None:
        return first
    random, joints = np.random.default_rng(_SEED), len(robot.stiffness)
    low = np.where(np.isfinite(robot.links.low), robot.links.low, -np.pi)[:joints]
    high = np.where(np.isfinite(robot.links.high), robot.links.high, np.pi)[:joints]
    found: list[FloatArray] = []
    for _ in range(_STARTS):
        start = posture.copy()
        start[:joints] = random.uniform(low, high)
        other = _descend(robot, position, rotation, start)
        if other is not None:
            found.append(other)
    if found:
        return min(found, key=lambda q: float(np.linalg.norm(q - posture)))
    what = "no joint coordinates within the limits bring the tip of the nominal robot there"
    raise ConvergenceError(
        what, where=where, remedy="Check reach, frame (argument `frame`) and unit, or state a posture."
    )


def _descend(robot: Robot, position: FloatArray, rotation: FloatArray, start: FloatArray) -> FloatArray | None:
    """Damped Gauss-Newton from a start (n_q,); None where it does not arrive, or beyond the limits."""
    from scipy.spatial.transform import Rotation  # noqa: PLC0415 (slow to import, and few need it)

    q, joints = start.copy(), len(robot.stiffness)
    for _ in range(_ITERATIONS):
        jacobians = robot.jacobians(q[None])
        turn = Rotation.from_matrix(rotation @ jacobians.rotation[0].T).as_rotvec()
        error = np.concatenate([position - robot.position(q[None])[0], turn])
        if np.abs(error).max() < _REACHED:
            break
        forward = jacobians.forward[0]
        damped = forward @ forward.T + 1e-4 * min(1.0, float(error @ error)) * np.eye(6)
        step = forward.T @ np.linalg.solve(damped + 1e-12 / CONDITION_LIMIT * np.eye(6), error)
        q[:joints] += step * min(1.0, _LARGEST / max(float(np.abs(step).max()), 1e-12))
    else:
        return None
    # Turns by whole revolutions are the same posture.
    for index in range(joints):
        if robot.units[index] == "rad":
            q[index] -= 2.0 * np.pi * np.round((q[index] - start[index]) / (2.0 * np.pi))
            for shift in (0.0, -2.0 * np.pi, 2.0 * np.pi):
                if robot.links.low[index] <= q[index] + shift <= robot.links.high[index]:
                    q[index] += shift
                    break
    return q if float(robot.limit_excess(q)) <= _REACHED else None
