"""What errors of an arm's geometry and its own weight do to its tip, as geometric plans use it; pinocchio as oracle."""

from pathlib import Path

import numpy as np
import pandas as pd
import pinocchio as pin
import pytest

import expdesign as xd
from expdesign.mechanics.elastostatics.arm_calibration import ArmElastostatic, ArmGeometric
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.loads.load import Wrench
from expdesign.mechanics.robots.robot import Robot
from expdesign.mechanics.robots.robot_file import read_robot
from tests.plant import HIGH, JOINTS, LOW, STIFFNESS, Arm, Faults, configuration

STEP = 1e-6
COMMANDS = np.random.default_rng(4).uniform(LOW, HIGH, (5, 6))
PLACES = np.vstack([np.zeros(3), np.eye(3)])


@pytest.fixture(scope="module")
def robot() -> Robot:
    return read_robot(Path(__file__).parents[2] / "configs" / "robots" / "ur5.yaml")


def moved(faults: Faults) -> np.ndarray:
    """Twists (5, 6) of the tip in the base's axes, from the robot as drawn, whose joints do not yield."""
    twists = []
    for command in COMMANDS:
        stiff = [Arm(each) for each in (faults, Faults(softness=np.zeros(6)))]
        poses = [arm_pose(arm, command) for arm in stiff]
        turn = pin.log3(poses[0].rotation @ poses[1].rotation.T)
        twists.append(np.concatenate([poses[0].translation - poses[1].translation, turn]))
    return np.array(twists)


def arm_pose(arm: Arm, command: np.ndarray) -> pin.SE3:
    arm.position(command, np.zeros(3))
    return arm._data.oMf[arm._tip].copy()


def test_every_error_of_the_geometry_moves_the_tip_as_in_pinocchio(robot: Robot) -> None:
    regressor = ArmGeometric()
    loaded = LoadedRobot(robot, Wrench(robot.coordinates), regressor=regressor)
    matrix = loaded.measure(COMMANDS, np.zeros((5, 6))).observation
    names = regressor.names(robot)
    ends = [end.name for end in robot.links.tree.ends]
    urdf = [joint.joint for joint in robot.links.tree.coordinates]
    compared = 0
    for column, name in enumerate(names):
        zeros, frames = np.zeros(6), np.zeros((6, 6))
        label, _, part = name.rpartition(" ")
        if part == "offset":
            zeros[int(label.split()[1]) - 1] = STEP
        else:
            owner = ends[[n.rpartition(" ")[0] for n in robot.links.tree.geometry_names[6::6]].index(label)]
            if owner not in urdf:
                continue  # the tip's own frame
            frames[urdf.index(owner), ("x", "y", "z", "rx", "ry", "rz").index(part)] = STEP
        expected = moved(Faults(zeros=zeros, placements=frames, softness=np.zeros(6))) / STEP
        np.testing.assert_allclose(matrix[..., column], expected, atol=2e-5)
        compared += 1
    assert compared >= 24  # six for every turning joint are there, two of each cannot be told from its neighbours'


def test_own_weight_bends_the_joints_as_in_pinocchio(robot: Robot) -> None:
    loaded = LoadedRobot(robot, Wrench(robot.coordinates), regressor=ArmElastostatic())
    matrix = loaded.measure(COMMANDS, np.zeros((5, 6))).observation
    for joint in range(6):
        softness = np.zeros(6)
        softness[joint] = 1e-2
        expected = moved(Faults(softness=softness)) * STIFFNESS[joint] / 1e-2
        np.testing.assert_allclose(matrix[..., joint], expected, rtol=2e-3, atol=1e-3 * np.abs(matrix).max())


def test_unknown_frames_leave_eighteen_parameters_of_three_parallel_axes(robot: Robot) -> None:
    names = ArmGeometric(frames_known=False).names(robot)
    assert len(names) == 12 + 18
    assert names[:12] == tuple(f"{f} {p}" for f in ("instrument", "target") for p in ("x", "y", "z", "rx", "ry", "rz"))


def test_a_plan_for_the_targets_is_better_there_than_random_poses() -> None:
    config = configuration(12)
    config["optimiser"] = {"population": 12, "generations": 6, "seed": 1}
    found = xd.run(config, seconds=6.0)
    generator, values = np.random.default_rng(0), []
    for _ in range(9):
        frame = pd.DataFrame(generator.uniform(LOW, HIGH, (12, 6)), columns=JOINTS)
        frame = frame.assign(sequence=range(1, 13), series=range(1, 13))
        values.append(xd.evaluate(config, frame).record["duir"])
    assert float(found.pareto["duir"].min()) < 0.7 * float(np.median(values))
    assert set(JOINTS) <= set(found.plan.columns)
