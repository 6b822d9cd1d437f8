"""What the links' own weight does where it shows: positions, and the sag that they hold."""

from pathlib import Path

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest

from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.effects.joints.bearings import JointCompliance
from expdesign.chain.effects.links.links import LinkMassError
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.row import row_data
from expdesign.mechanics.robots.robot_file import read_robot
from expdesign.mechanics.robots.serial import SerialRobot
from tests.chain.arms import configurations, read_arm, recordings_of, write_arm
from tests.oracle import Array
from tests.robots.arms import ARMS, Oracle, serial_robot


@pytest.mark.parametrize("name", ["ur5", "tiago"])
def test_what_lies_beyond_a_joint_has_the_mass_and_centre_of_its_subtree(name: str) -> None:
    robot = serial_robot(ARMS[name])
    oracle = Oracle(robot)
    count = len(robot.configuration)
    q = np.random.default_rng(0).uniform(0.1, 0.3, count)
    oracle.placement(q)
    pin.centerOfMass(oracle.model, oracle.data, oracle.full(q), True)
    symbol = ca.SX.sym("q", count)
    for link in range(count):
        beyond = np.arange(count) >= link
        mass, moments = robot.tree.masses() @ beyond, robot.tree.weight(symbol, None, ca.SX(beyond.astype(float)))[1:]
        found = np.array(ca.Function("moments", [symbol], [moments])(q)).ravel() / mass
        joint = oracle.model.getJointId(robot.tree.joints[link].name)
        centre = oracle.data.oMf[oracle.base].inverse() * (oracle.data.oMi[joint] * oracle.data.com[joint])
        assert mass == pytest.approx(oracle.data.mass[joint], rel=1e-12)
        np.testing.assert_allclose(found, centre, atol=1e-12)


def _positions(robot: SerialRobot, effects: tuple[Effect, ...], parameters: list[float]) -> Array:
    """Positions of a marker at the tip's origin, read in the base frame."""
    robot.markers, robot.instrument = {"ball": np.zeros(3)}, np.zeros(6)
    recordings = recordings_of(robot, configurations(6, seed=3), np.zeros((6, 3)))
    chain = Chain(robot, effects, reading=reading_of(robot, recordings))
    values = chain.start()
    values[len(values) - len(parameters) :] = parameters
    return chain.predict(row_data(recordings, robot), values)


def test_a_heavier_link_is_a_urdf_with_a_heavier_link(tmp_path: Path) -> None:
    robot = read_arm(tmp_path)
    found = _positions(robot, (LinkMassError.from_text(robot, "link 4"),), [0.25])
    other = tmp_path / "other"
    other.mkdir()
    file = write_arm(other)
    urdf = other / "arm.urdf"
    urdf.write_text(urdf.read_text().replace('<mass value="4.0"/>', '<mass value="5.0"/>'))
    heavier = read_robot(file)
    assert isinstance(heavier, SerialRobot)
    plain = _positions(robot, (), [])
    expected = _positions(heavier, (), [])
    assert np.abs(expected - plain).max() > 1e-6
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12)


def test_a_bearing_tilts_under_the_weight_beyond_it(tmp_path: Path) -> None:
    """The tilt about a horizontal axis through the waist is its compliance times the moment of what it carries."""
    robot = read_arm(tmp_path)
    tilted = _positions(robot, (JointCompliance.from_text(robot, "joint 2", ""),), [1e-6]) - _positions(robot, (), [])
    q = configurations(6, seed=3)
    model = pin.buildModelFromUrdf(str(tmp_path / "arm.urdf"))
    data = model.createData()
    for row, command in enumerate(q):
        pin.centerOfMass(model, data, command, True)
        waist = data.oMi[2].translation
        arm = data.oMi[2] * data.com[2] - waist
        turn = 1e-6 * np.cross(arm, data.mass[2] * robot.gravity)
        assert abs(turn[2]) < 1e-15  # the waist's axis is vertical: all of it lies across
        expected = np.cross(turn, robot.position(command) - waist)
        np.testing.assert_allclose(tilted[row], expected, rtol=0.0, atol=1e-11)


def test_positions_show_the_equilibrium_to_second_order(tmp_path: Path) -> None:
    """Oracle: the fixed point of δ = c∘τ(q + δ) with pinocchio's torques. What is left is of third order in c."""
    robot = read_arm(tmp_path)
    robot.markers, robot.instrument = {"ball": np.zeros(3)}, np.zeros(6)
    q = configurations(6, seed=3)
    recordings = recordings_of(robot, q, np.zeros((6, 3)))
    chain, rows = Chain(robot, reading=reading_of(robot, recordings)), row_data(recordings, robot)
    model = pin.buildModelFromUrdf(str(tmp_path / "arm.urdf"))
    model.gravity.linear = robot.gravity
    data = model.createData()

    def stands(command: Array, softness: float) -> Array:
        bent = command
        for _ in range(50):
            torque = -pin.computeGeneralizedGravity(model, data, bent)
            bent = command + softness * torque / robot.stiffness
        return robot.position(bent)

    def off(softness: float) -> float:
        values = chain.start()
        values[: chain.compliances] = softness
        exact = np.array([stands(command, softness) for command in q])
        return float(np.abs(chain.predict(rows, values) - exact).max())

    assert off(20.0) < 2e-4 * np.abs(robot.position(q) - [stands(command, 20.0) for command in q]).max()
    assert off(40.0) / off(20.0) == pytest.approx(8.0, rel=0.05)
