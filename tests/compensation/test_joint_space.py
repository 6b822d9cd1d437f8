"""Commands of arms: the tip ends where the unloaded arm would stand, with no more motion than that takes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from expdesign.chain.chain import Chain
from expdesign.chain.effects.joints.bearings import JointCompliance
from expdesign.chain.models.model_file import Model
from expdesign.chain.recordings.points import points_from_table
from expdesign.chain.recordings.recordings import LoadedPoints, Recordings
from expdesign.chain.row import row_data
from expdesign.errors import ConvergenceError, SingularConfigurationError
from expdesign.estimation.compensation.compensate import compensate
from expdesign.estimation.compensation.prediction import moved
from expdesign.mechanics.robots.kinematic_tree import KinematicTree
from expdesign.mechanics.robots.serial import SerialRobot
from tests.chain.arm_rows import arm_rows, six_axis
from tests.identification.experiments import read, table_of
from tests.oracle import Array
from tests.robots.arms import ARMS, serial_robot
from tests.robots.torso import LIFTED, read_torso

ARM = six_axis()


def model_of(robot: SerialRobot, *effects: tuple[type[JointCompliance], str, list[float]]) -> Model:
    made = tuple(kind.from_text(robot, component) for kind, component, _ in effects)
    chain = Chain(robot, made)
    values = np.concatenate([np.ones(chain.compliances), *(parameters for _, _, parameters in effects)])
    return Model(chain, values, 0.01 * np.eye(len(values)), {}, Path(), "model.yaml")


def errors_after(
    model: Model, targets: Recordings, commands: Array, there: LoadedPoints | None = None
) -> tuple[Array, Array]:
    """Position and turn from the target to the tip that the model predicts at the commands, which `there` holds."""
    robot = model.chain.robot
    assert isinstance(robot, SerialRobot)
    deflection = model.chain.predict(row_data(there or moved(targets, commands, robot), robot), model.values)
    position = robot.position(commands) + deflection[:, :3] - robot.position(targets.configurations)
    turn = robot.jacobians(commands).rotation @ robot.jacobians(targets.configurations).rotation.swapaxes(-1, -2)
    return position, (Rotation.from_rotvec(deflection[:, 3:]) * Rotation.from_matrix(turn)).as_rotvec()


def test_the_whole_deflection_is_undone_also_what_the_joints_do_not_make() -> None:
    model = model_of(ARM, (JointCompliance, "joint 2", [2e-5]))
    targets = read(arm_rows(ARM, series=6, loads=1), ARM)
    found = compensate(model, targets)
    position, turn = errors_after(model, targets, found.commands)
    assert np.abs(position).max() < 1e-10
    assert np.abs(turn).max() < 1e-7  # a deflection turns to second order
    assert np.abs(found.commands - targets.configurations).max() > 1e-3
    assert (found.deviations > 0.0).all()


def test_what_hangs_on_a_soft_arm_hangs_as_the_command_turns_it() -> None:
    """Commands in a table with the same payload: it is read anew, and predicted to be where it was wanted."""
    model = model_of(ARM)
    values = model.values.copy()
    values[: model.chain.compliances] = 30.0
    model = replace(model, values=values)
    rows = arm_rows(ARM, series=6, loads=1).assign(com_x_m=0.1, com_z_m=0.3)
    targets = read(rows, ARM)
    commands = compensate(model, targets).commands
    again = rows.copy()
    again.loc[rows["sequence"].argsort(), list(ARM.configuration)] = commands
    position, _ = errors_after(model, targets, commands, points_from_table(table_of(again), ARM))
    assert np.abs(commands - targets.configurations).max() > 5e-3
    assert np.abs(position).max() < 1e-9


def test_a_redundant_arm_moves_no_more_than_it_must() -> None:
    """Seven joints for six components: the correction is the least-norm one, in parts of each joint's range."""
    panda = serial_robot(ARMS["panda"])
    frame = arm_rows(panda, series=5, loads=1)
    frame["q4_rad"] = np.linspace(-2.0, -1.0, 5)
    targets = read(frame, panda)
    model = model_of(panda)
    found = compensate(model, targets)
    position, turn = errors_after(model, targets, found.commands)
    assert max(np.abs(position).max(), np.abs(turn).max()) < 1e-7
    scaled = (found.commands - targets.configurations) / (panda.high - panda.low)
    for q, step in zip(targets.configurations, scaled, strict=True):
        jacobian = panda.jacobians(q).forward * (panda.high - panda.low)
        null = np.linalg.svd(jacobian)[2][6]
        assert abs(null @ step) < 0.01 * np.linalg.norm(step)


def test_an_arm_with_too_few_joints_keeps_the_position() -> None:
    """The first three joints alone: the position of the wrist is reached, its orientation is not."""
    tree = KinematicTree(ARM.tree.urdf, "base", ["forearm"])
    short = SerialRobot(tree, np.array([2e4, 2e4, 1e4]))
    frame = arm_rows(ARM, series=4, loads=1).drop(columns=["q4_rad", "q5_rad", "q6_rad"])
    frame = frame.drop(columns=[f"leg{i}_degC" for i in range(1, 7)])
    targets = read(frame, short)
    model = model_of(short)
    before = np.linalg.norm(model.chain.predict(row_data(targets, short), model.values)[:, :3], axis=1)
    found = compensate(model, targets)
    position, _ = errors_after(model, targets, found.commands)
    # The origin of the forearm is moved by two joints only; what lies across their plane cannot be undone.
    assert (np.linalg.norm(position, axis=1) < 0.05 * before).all()


def test_a_hand_that_five_of_eight_joints_move_keeps_the_position(tmp_path: Path) -> None:
    """Joints of the other hand do not make it an arm that reaches every orientation."""
    torso = read_torso(tmp_path)
    q = np.random.default_rng(1).uniform(-0.6, 0.6, (4, 8))
    nothing = dict.fromkeys((*LIFTED, "com_x_m", "com_y_m", "com_z_m"), 0.0)
    frame = pd.DataFrame(q, columns=list(torso.configuration[:8])).assign(tip="right_hand", mass_kg=2.0, **nothing)
    points = points_from_table(table_of(frame), torso)
    model = model_of(torso)
    before = np.linalg.norm(model.chain.predict(row_data(points, torso), model.values)[:, :3], axis=1)
    commands = compensate(model, points).commands
    reached = model.chain.predict(row_data(moved(points, commands, torso), torso), model.values)[:, :3]
    position = torso.position(commands) + reached - torso.position(points.configurations)
    assert (np.linalg.norm(position, axis=1) < 0.05 * before).all()


def far_from_stretched() -> Array:
    q = arm_rows(ARM, series=6, loads=1)[list(ARM.configuration)].to_numpy()
    found: Array = q[np.linalg.cond(ARM.jacobians(q).forward) < 50.0]
    return found


@pytest.mark.parametrize(
    ("commands", "mass", "error", "words"),
    [
        # Elbow, shoulder and wrist in line: no joint shortens the arm, and a weight that pulls along it is not undone.
        (np.array([[0.0, -0.3, 0.0, 0.0, 0.0, 0.0]]), None, SingularConfigurationError, "singular"),
        (far_from_stretched(), 2e4, ConvergenceError, "corrected by"),
    ],
    ids=["stretched", "a load far beyond reason"],
)
def test_what_no_joint_can_undo_is_refused(
    commands: Array, mass: float | None, error: type[Exception], words: str
) -> None:
    model = model_of(ARM, (JointCompliance, "joint 5", [1e-4])) if mass is None else model_of(ARM)
    frame = arm_rows(ARM, series=len(commands), loads=1)
    frame[list(ARM.configuration)] = commands
    with pytest.raises(error, match=words):
        compensate(model, read(frame if mass is None else frame.assign(mass_kg=mass), ARM))
