"""Poses from measured points (theory.md 9.A)."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from expdesign.chain.readings.registration import pose_covariance, registered, twist_covariance
from expdesign.errors import InputError
from expdesign.io.yaml_reader import YamlDocument
from expdesign.planning.problem_file import problem_from_document, read_problem
from tests.design.problems import BIPOD, HEXAPOD, problem

POINTS = np.array([[0.06, 0.0, 0.05], [-0.03, 0.05, 0.05], [-0.03, -0.05, 0.05], [0.0, 0.0, 0.07]])
TURNED = Rotation.from_euler("xyz", [0.1, -0.2, 0.3])


def test_exact_points_give_the_exact_pose() -> None:
    position = np.array([0.1, 0.2, 0.3])
    rotation, found = registered(POINTS, POINTS @ TURNED.as_matrix().T + position)
    np.testing.assert_allclose(rotation, TURNED.as_matrix(), atol=1e-14)
    np.testing.assert_allclose(found, position, atol=1e-15)


def test_points_in_a_plane_are_never_mirrored() -> None:
    flat = POINTS * [1.0, 1.0, 0.0]
    noise = np.random.default_rng(1).normal(0.0, 1e-3, (500, 4, 3))
    rotation, _ = registered(flat, flat @ TURNED.as_matrix().T + noise)
    np.testing.assert_allclose(np.linalg.det(rotation), 1.0, atol=1e-12)


def test_noise_of_the_points_becomes_the_covariance_of_the_pose() -> None:
    count, deviation = 40_000, 1e-6
    turned = TURNED.as_matrix()
    noise = np.random.default_rng(2).normal(0.0, deviation, (count, *POINTS.shape))
    rotation, position = registered(POINTS, POINTS @ turned.T + noise)
    twist = np.concatenate([position, Rotation.from_matrix(rotation @ turned.T).as_rotvec()], axis=1)
    expected = twist_covariance(POINTS, deviation, turned)
    scale = np.sqrt(np.diag(expected))
    difference = (np.cov(twist.T) - expected) / np.outer(scale, scale)
    # Standard error of a covariance of unit normals: √((1 + ρ²)/N) ≤ √(2/N).
    assert np.abs(difference).max() < 4.0 * np.sqrt(2.0 / count)
    # Points above the frame: a turn about y moves the origin along x.
    correlation = expected[0, 4] / (scale[0] * scale[4])
    assert abs(correlation) > 0.5


def test_a_configuration_takes_twice_the_covariance_of_one_pose() -> None:
    here = problem(HEXAPOD, {"experiment.deflection_noise": {"points": {"positions": POINTS.tolist(), "std_m": 1e-6}}})
    np.testing.assert_allclose(here.noise.covariance, 2.0 * twist_covariance(POINTS, 1e-6, np.eye(3)), atol=1e-22)


@pytest.mark.parametrize(
    ("base", "changes", "words"),
    [
        (HEXAPOD, {"positions": [[0, 0, 0], [1, 0, 0], [2, 0, 0]], "std_m": 1e-6}, "do not determine"),
        (HEXAPOD, {"positions": [[0, 0, 0], [1, 0, 0]], "std_m": 1e-6}, "do not determine"),
        (HEXAPOD, {"positions": POINTS.tolist(), "std_m": 1e-6, "pose": [0.0]}, "6 numbers"),
        (BIPOD, {"positions": POINTS.tolist(), "std_m": 1e-6}, "six pose coordinates"),
    ],
)
def test_points_that_cannot_be_are_named(base: dict[str, object], changes: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        problem(base, {"experiment.deflection_noise": {"points": changes}})


def test_an_arm_that_is_singular_at_zero_is_measured_with_points() -> None:
    """A UR5 stands stretched with all joints at zero; the noise of a registered pose needs no inverse of its J."""
    configs = Path(__file__).parents[2] / "configs"
    known = read_problem(configs / "ur5.yaml")
    config, rotation = known.config, known.loaded.robot.jacobians(np.zeros(6)).rotation
    config["robot"]["urdf"] = str(configs / "robots" / "ur5.urdf")
    config["experiment"]["deflection_noise"] = {"points": {"positions": POINTS.tolist(), "std_m": 1e-6}}
    noise = problem_from_document(YamlDocument("ur5", Path(), config)).noise
    expected = 2.0 * pose_covariance(POINTS, 1e-6, rotation, np.eye(6))
    np.testing.assert_allclose(noise.covariance, expected, rtol=1e-12)
