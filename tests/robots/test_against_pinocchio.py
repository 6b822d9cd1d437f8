"""Kinematics, torques and deflections of published arms against an independent library."""

import numpy as np
import pinocchio as pin
import pytest

from expdesign.arrays import FloatArray
from expdesign.mechanics.elastostatics.maps import observation_matrix
from expdesign.mechanics.robots.serial import SerialRobot
from tests.robots.arms import ARMS, Oracle, serial_robot

GRAVITY = np.array([1.5, -2.0, -9.4])


@pytest.fixture(params=sorted(ARMS), scope="module")
def pair(request: pytest.FixtureRequest) -> tuple[SerialRobot, Oracle]:
    robot = serial_robot(ARMS[request.param])
    assert robot.configuration == ARMS[request.param].configuration
    return robot, Oracle(robot)


def _configurations(robot: SerialRobot, count: int = 5) -> FloatArray:
    """Drawn within the limits, or within a turn."""
    low, high = np.maximum(robot.low, -3.0), np.minimum(robot.high, 3.0)
    return np.random.default_rng(3).uniform(low, high, (count, len(low)))


def test_pose_of_the_tip(pair: tuple[SerialRobot, Oracle]) -> None:
    robot, oracle = pair
    configurations = _configurations(robot)
    positions, rotations = robot.position(configurations), robot.jacobians(configurations).rotation
    for q, position, rotation in zip(configurations, positions, rotations, strict=True):
        expected = oracle.placement(q)
        np.testing.assert_allclose(position, expected.translation, atol=1e-12)
        np.testing.assert_allclose(rotation, expected.rotation, atol=1e-12)


def test_jacobian(pair: tuple[SerialRobot, Oracle]) -> None:
    robot, oracle = pair
    for q in _configurations(robot):
        np.testing.assert_allclose(robot.jacobians(q).forward, oracle.jacobian(q), atol=1e-11)


def test_torques_of_the_links_weight(pair: tuple[SerialRobot, Oracle]) -> None:
    robot, oracle = pair
    for q in _configurations(robot):
        expected = oracle.own_weight(q, GRAVITY)
        assert np.abs(expected).max() > 0.5
        np.testing.assert_allclose(robot.own_weight(q, GRAVITY), expected, atol=1e-9)


def test_deflection_is_what_the_turned_joints_do(pair: tuple[SerialRobot, Oracle]) -> None:
    """The joints turn by torque over stiffness; the oracle's tip then moves by the predicted deflection."""
    robot, oracle = pair
    wrench = np.array([30.0, -20.0, -80.0, 4.0, 6.0, -3.0])
    for q in _configurations(robot):
        jacobians = robot.jacobians(q)
        deflection = observation_matrix(jacobians, wrench) @ robot.compliance
        size = 1e-4
        turned = q + size * (oracle.jacobian(q).T @ wrench) / robot.stiffness
        before, after = oracle.placement(q), oracle.placement(turned)
        vector = pin.log3(after.rotation @ before.rotation.T)
        moved = np.concatenate([after.translation - before.translation, vector]) / size
        np.testing.assert_allclose(moved, deflection, rtol=1e-3, atol=2e-5 * np.abs(deflection).max())
