"""Serial robots from URDF: what the reader takes and refuses, mimic joints, limits, and errors of the geometry."""

from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from expdesign.errors import InputError
from expdesign.mechanics.robots.kinematic_tree import FRAME_AXES, KinematicTree
from expdesign.mechanics.robots.serial import SerialRobot
from expdesign.mechanics.robots.urdf import read_urdf
from tests.oracle import Array

# A lift of two stages that follow a motor beside the chain, an arm with a tool, a finger that hangs beside the chain.
ROBOT = """<robot name="r">
  <link name="base"/><link name="motor"/><link name="tip"/>
  <link name="middle"><inertial><mass value="4"/></inertial></link>
  <link name="top"><inertial><origin xyz="0.1 0 0"/><mass value="3"/></inertial></link>
  <link name="arm"><inertial><origin xyz="0.2 0 0"/><mass value="2"/></inertial></link>
  <link name="finger"><inertial><origin xyz="0 0 0.05"/><mass value="0.5"/></inertial></link>
  <joint name="lift" type="prismatic"><parent link="base"/><child link="motor"/><axis xyz="0 0 2"/>
    <limit lower="0.1" upper="0.9" effort="1" velocity="1"/></joint>
  <joint name="first" type="prismatic"><parent link="base"/><child link="middle"/><axis xyz="0 0 1"/>
    <mimic joint="lift" multiplier="0.5" offset="0.2"/><limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
  <joint name="second" type="prismatic"><origin xyz="0 0 0.3"/><parent link="middle"/><child link="top"/>
    <axis xyz="0 0 1"/><mimic joint="first" multiplier="1" offset="0.1"/></joint>
  <joint name="turn" type="revolute"><origin xyz="0 0 0.1" rpy="0.1 0.2 0.3"/><parent link="top"/>
    <child link="arm"/><axis xyz="0 1 0"/><limit lower="-1" upper="2" effort="1" velocity="1"/></joint>
  <joint name="grip" type="prismatic"><origin xyz="0.4 0 0"/><parent link="arm"/><child link="finger"/>
    <limit lower="0.02" upper="0.05" effort="1" velocity="1"/></joint>
  <joint name="tool" type="fixed"><origin xyz="0.5 0 0.1" rpy="0 0.5 0"/><parent link="arm"/><child link="tip"/></joint>
</robot>"""
POINT = np.array([0.4, 0.7])


def written(folder: Path, text: str = ROBOT) -> Path:
    path = folder / "robot.urdf"
    path.write_text(text, encoding="utf-8")
    return path


def robot_of(folder: Path, text: str = ROBOT, base: str = "base", tip: str = "tip") -> SerialRobot:
    tree = KinematicTree(read_urdf(written(folder, text)), base, [tip])
    return SerialRobot(tree, np.full(len(tree.coordinates), 1e4))


def test_a_mimicked_joint_stands_for_those_that_mimic_it(tmp_path: Path) -> None:
    """Both stages go up by half the lift, each with its offset: 0.5 q + 0.2 and 0.5 q + 0.3."""
    robot = robot_of(tmp_path)
    assert robot.configuration == ("q1_m", "q2_rad")
    assert [c.joint for c in robot.tree.coordinates] == ["lift", "turn"]
    np.testing.assert_allclose(robot.low, [0.1, -1.0])
    np.testing.assert_allclose(robot.high, [0.9, 2.0])
    raised = robot.position(POINT + np.array([0.1, 0.0])) - robot.position(POINT)
    np.testing.assert_allclose(raised, [0.0, 0.0, 0.1], atol=1e-15)
    poses = robot.tree.forward(ca.SX(POINT))
    heights = [float(ca.DM(poses[name][2, 3])) for name in ("middle", "top")]
    np.testing.assert_allclose(heights, [0.2 + 0.2, 0.4 + 0.3 + 0.2 + 0.3], rtol=1e-14)
    np.testing.assert_allclose(robot.jacobians(POINT).forward[:, 0], [0, 0, 1, 0, 0, 0], atol=1e-15)


def test_every_mass_weighs_with_the_joint_that_carries_it(tmp_path: Path) -> None:
    """The lift carries all but half of the middle stage's way; the finger hangs at the limit of its grip."""
    robot = robot_of(tmp_path)
    torque = robot.own_weight(POINT, robot.gravity)
    assert torque[0] == pytest.approx(-9.80665 * (0.5 * 4.0 + 3.0 + 2.0 + 0.5), rel=1e-12)
    np.testing.assert_allclose(robot.tree.masses(), [7.0, 2.5])
    finger = robot.tree.forward(ca.SX(POINT))["finger"]
    arm = robot.tree.forward(ca.SX(POINT))["arm"]
    grip = np.array(ca.DM(finger[:3, 3] - arm[:3, 3])).ravel()
    assert np.linalg.norm(grip) == pytest.approx(0.42)


def test_limits_of_the_robot_file_narrow_those_of_the_urdf(tmp_path: Path) -> None:
    tree = robot_of(tmp_path).tree
    robot = SerialRobot(tree, np.ones(2), limits={"q2_rad": (-5.0, 0.5)})
    assert (robot.low[1], robot.high[1]) == (-1.0, 0.5)
    np.testing.assert_allclose(robot.reference_configuration(), [0.5, 0.0])
    assert float(robot.limit_excess(np.array([0.4, 0.7]))) == pytest.approx(0.2)
    assert "joint 2 (`turn`)" in robot.limit_message(np.array([0.4, 0.7]))
    assert bool(robot.usable(np.array([0.4, 0.5])))


def _with_error(robot: SerialRobot, name: str, size: float) -> tuple[Array, Array]:
    geometry = np.zeros(robot.tree.size)
    geometry[robot.tree.geometry_names.index(name)] = size
    q, errors = ca.SX.sym("q", 2), ca.SX.sym("errors", robot.tree.size)
    position, rotation = ca.Function("tip", [q, errors], list(robot.tip(q, errors))).call([POINT, geometry])
    return np.array(position).ravel(), np.array(rotation)


def test_an_offset_is_another_coordinate(tmp_path: Path) -> None:
    robot = robot_of(tmp_path)
    position, rotation = _with_error(robot, "joint 2 offset", 0.05)
    shifted = POINT + np.array([0.0, 0.05])
    np.testing.assert_allclose(position, robot.position(shifted), atol=1e-15)
    np.testing.assert_allclose(rotation, robot.jacobians(shifted).rotation, atol=1e-15)


@pytest.mark.parametrize("link", [0, 1, 2])
@pytest.mark.parametrize("axis", FRAME_AXES)
def test_a_link_error_moves_what_lies_beyond_its_far_end(tmp_path: Path, link: int, axis: str) -> None:
    """The next joint's frame moves in its own axes: for link 2 that is the tip, for link 0 the first stage."""
    robot = robot_of(tmp_path)
    before, turned = _with_error(robot, f"link {link} {axis}", 0.0)
    position, rotation = _with_error(robot, f"link {link} {axis}", 1e-6)
    poses = robot.tree.forward(ca.SX(POINT))
    pose = np.array(ca.DM(poses[("base", "top", "tip")[link]]))
    if link == 1:
        pose = pose @ robot.tree.urdf.joints["turn"].origin
    frame, place = pose[:3, :3], pose[:3, 3]
    direction = frame[:, "xyz".index(axis[-1])]
    expected = direction if len(axis) == 1 else np.cross(direction, before - place)
    np.testing.assert_allclose((position - before) / 1e-6, expected, atol=1e-5)
    turn = (rotation @ turned.T - np.eye(3)) / 1e-6
    np.testing.assert_allclose([turn[2, 1], turn[0, 2], turn[1, 0]], direction * (len(axis) == 2), atol=1e-5)


def test_one_joint_is_a_robot(tmp_path: Path) -> None:
    robot = robot_of(tmp_path, base="top")
    assert robot.configuration == ("q1_rad",)
    assert robot.jacobians(np.array([0.3])).forward.shape == (6, 1)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("<robot name", "<robots name", "not valid XML|outermost"),
        ("</robot>", "", "not valid XML"),
        ('<link name="base"/>', '<link name="base"/><link name="base"/>', "two links `base`"),
        ('type="revolute"', 'type="rotary"', "unknown type of joint `rotary`"),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 0 0"/>', "no direction"),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 0 1e200"/>', "beyond any quantity"),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 one 0"/>', "3 numbers are needed"),
        ('<mass value="3"/>', '<mass value="-3"/>', "cannot be negative"),
        ('<mass value="3"/>', '<mass value="nan"/>', "1 number is needed"),
        ('lower="-1" upper="2"', 'lower="2" upper="-1"', "the wrong way round"),
        ('joint="lift"', 'joint="lft"', "mimics `lft`, which is not there. Did you mean `lift`"),
        ('joint="lift"', 'joint="second"', "mimics itself"),
        ('<parent link="base"/><child link="middle"/>', '<parent link="tip"/><child link="middle"/>', "carries itself"),
        ('<child link="tip"/>', '<child link="arm"/>', "hangs on two joints"),
        ("<robot name", '<!DOCTYPE x [<!ENTITY a "b">]><robot name', "document type"),
        ('<joint name="turn" type="revolute">', '<joint name="turn" type="floating">', "is floating"),
    ],
)
def test_a_wrong_urdf_is_named(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert old in ROBOT
    with pytest.raises(InputError, match=message) as caught:
        robot_of(tmp_path, ROBOT.replace(old, new))
    assert "robot.urdf" in caught.value.where


@pytest.mark.parametrize(
    ("base", "tip", "message"),
    [
        ("base", "tipp", "Did you mean `tip`"),
        ("tip", "base", "does not carry"),
        ("arm", "tip", "no joint moves between"),
    ],
)
def test_wrong_ends_are_named(tmp_path: Path, base: str, tip: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        robot_of(tmp_path, base=base, tip=tip)


def test_the_shipped_arm_has_the_published_reach() -> None:
    """The project's own UR5 and the one of the package index put the flange in the same place, half a turn apart."""
    from tests.chain.arm_rows import six_axis  # noqa: PLC0415
    from tests.robots.arms import ARMS, serial_robot  # noqa: PLC0415

    q = np.random.default_rng(0).uniform(-3.0, 3.0, (20, 6))
    published = serial_robot(ARMS["ur5"]).position(q)
    np.testing.assert_allclose(six_axis().position(q), published * [-1.0, -1.0, 1.0], atol=2e-5)
