"""Robot files (file-formats.md, Robot files)."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from expdesign.mechanics.robots.bipod import Bipod
from expdesign.mechanics.robots.hexapod import Hexapod
from expdesign.mechanics.robots.robot_file import read_robot
from tests.design.problems import BIPOD, HEXAPOD

SHIPPED = sorted((Path(__file__).parents[2] / "configs" / "robots").glob("*.yaml"))


def test_the_file_of_the_interfaces(tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    joints = HEXAPOD["robot"]
    path.write_text(
        "name: demo\nkind: hexapod\norientation: moving-xyz\nhome: [0.0, 0.0, 0.25]\n"
        f"base_joints: {joints['base_joints']}\nplatform_joints: {joints['platform_joints']}\n"
        "actuator_stiffness: [2.5e7, 2.5e7, 2.5e7, 2.5e7, 2.5e7, 1e8]\nlimits:\n  leg_length: [0.2, 0.35]\n"
        "gravity_m_s2: [0, 1, -9]\n"
    )
    robot = read_robot(path)
    assert isinstance(robot, Hexapod)
    assert robot.orientation == "moving-xyz"
    assert robot.actuators == tuple(f"leg {i}" for i in range(1, 7))
    assert robot.leg_length == (0.2, 0.35)
    np.testing.assert_array_equal(robot.stiffness, [2.5e7] * 5 + [1e8])
    np.testing.assert_array_equal(robot.compliance, 1.0 / robot.stiffness)
    np.testing.assert_array_equal(robot.gravity, [0.0, 1.0, -9.0])
    np.testing.assert_array_equal(robot.base_joints, joints["base_joints"])
    np.testing.assert_array_equal(robot.platform_joints, joints["platform_joints"])
    np.testing.assert_array_equal(robot.home, [0.0, 0.0, 0.25])


def test_a_bipod_has_two_coordinates_and_standard_gravity(tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(yaml.safe_dump(BIPOD["robot"]))
    robot = read_robot(path)
    assert isinstance(robot, Bipod)
    assert robot.configuration == ("x_m", "y_m")
    np.testing.assert_array_equal(robot.gravity, [0.0, -9.80665])
    assert robot.leg_length is None


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_robots_are_regular_at_their_zero_pose_and_within_their_limits(path: Path) -> None:
    robot = read_robot(path)
    zero = np.array([0.0, 0.6]) if isinstance(robot, Bipod) else np.zeros(len(robot.configuration))
    assert bool(robot.usable(zero))
