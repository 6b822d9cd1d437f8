"""Kinematics of every robot of the table against finite differences and hand formulas."""

import casadi as ca
import numpy as np
import pytest

from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.symbolic import BatchFunction
from tests import oracle
from tests.cases import ROBOTS, robot
from tests.oracle import Array

every_robot = pytest.mark.parametrize("name", ROBOTS)


def some_poses(name: str, count: int = 12) -> Array:
    """Random poses and the zero pose (or the middle of the workspace of a robot that has none)."""
    poses = ROBOTS[name].poses(np.random.default_rng(3), count)
    poses[0] = (np.array(ROBOTS[name].low) + np.array(ROBOTS[name].high)) / 2.0
    return poses


def scaled(here: ParallelRobot, matrices: Array) -> Array:
    """Pose or twist rows with rotations multiplied by the size of the platform, so that rows can be compared."""
    n, translations = here.coordinates.n, here.coordinates.translations
    length = 1.0 if n == translations else np.ptp(here.platform_joints[:, 0])  # type: ignore[attr-defined]
    return matrices * np.where(np.arange(n) < translations, 1.0, length)[:, None]


def relative(difference: Array, reference: Array) -> float:
    """Largest relative error of a batch of matrices in the Frobenius norm."""
    return float((np.linalg.norm(difference, axis=(-2, -1)) / np.linalg.norm(reference, axis=(-2, -1))).max())


@every_robot
def test_pose_jacobian_is_the_inverse_derivative_of_the_lengths(name: str) -> None:
    here, poses = robot(name), some_poses(name)
    rates = oracle.central_difference(here.lengths, poses, 1e-5)
    exact = here.jacobians(poses).pose
    assert relative(scaled(here, exact - np.linalg.inv(rates)), scaled(here, exact)) < 1e-6


@every_robot
def test_jacobians_are_those_of_the_hand_formulas(name: str) -> None:
    here, poses = robot(name), some_poses(name)
    jacobians, by_hand = here.jacobians(poses), oracle.kinematics(here, poses)
    np.testing.assert_allclose(here.lengths(poses), by_hand.lengths, rtol=1e-14)
    assert relative(scaled(here, jacobians.forward - by_hand.forward), scaled(here, by_hand.forward)) < 1e-11
    assert relative(scaled(here, jacobians.pose - by_hand.pose), scaled(here, by_hand.pose)) < 1e-11
    np.testing.assert_allclose(jacobians.rotation, by_hand.rotation, atol=1e-15)


@every_robot
def test_symbolic_and_numeric_jacobians_agree(name: str) -> None:
    here, poses = robot(name), some_poses(name)
    pose = ca.SX.sym("X", here.coordinates.n)
    forward, pose_map, turned = BatchFunction("symbolic", [pose], [*here.jacobian_expressions(pose)])(poses)
    jacobians = here.jacobians(poses)
    assert relative(scaled(here, forward - jacobians.forward), scaled(here, jacobians.forward)) < 1e-9
    assert relative(scaled(here, pose_map - jacobians.pose), scaled(here, jacobians.pose)) < 1e-9
    np.testing.assert_allclose(turned, jacobians.rotation, atol=1e-15)


@every_robot
def test_any_batch_dimensions_give_the_same_numbers(name: str) -> None:
    here, poses = robot(name), some_poses(name)
    alone = np.stack([here.jacobians(pose).forward for pose in poses])
    folded = here.jacobians(poses.reshape(3, 2, 2, -1))
    np.testing.assert_array_equal(folded.forward.reshape(alone.shape), here.jacobians(poses).forward)
    np.testing.assert_allclose(here.jacobians(poses).forward, alone, rtol=1e-12, atol=1e-13 * np.abs(alone).max())
    assert folded.condition.shape == (3, 2, 2)
    assert here.jacobians(poses[:0]).forward.shape == (0, here.coordinates.n, here.coordinates.n)


def test_orientation_conventions_are_those_of_the_interfaces() -> None:
    angles = np.array([0.3, -0.5, 0.7])
    x, y, z = (oracle.about(axis, angles[axis]) for axis in range(3))
    pose = np.concatenate([np.zeros(3), angles])
    np.testing.assert_allclose(robot("H1").jacobians(pose).rotation, z @ y @ x, atol=1e-15)
    np.testing.assert_allclose(robot("moving-xyz").jacobians(pose).rotation, x @ y @ z, atol=1e-15)


@every_robot
def test_length_limits_are_an_excess_in_metres(name: str) -> None:
    case = ROBOTS[name]
    here, poses = case.make(), some_poses(name)
    assert np.all(here.limit_excess(poses) == -np.inf)
    lengths = here.lengths(poses)
    here.leg_length = (float(lengths.min()) + 0.001, float(lengths.max()) - 0.002)
    excess = here.limit_excess(poses)
    below, above = here.leg_length[0] - lengths, lengths - here.leg_length[1]
    np.testing.assert_allclose(excess, np.maximum(below, above).max(axis=-1), atol=1e-15)
    assert excess.max() == pytest.approx(0.002, abs=1e-12)
    worst = int(np.argmax(excess))
    leg = int(np.argmax(np.maximum(below, above)[worst]))
    assert here.limit_message(poses[worst]).startswith(f"leg {leg + 1} ")
    np.testing.assert_array_equal(here.usable(poses), (excess <= 1e-12) & (here.jacobians(poses).condition <= 100.0))
