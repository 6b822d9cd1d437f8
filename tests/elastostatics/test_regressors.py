"""Geometric calibration (theory.md 9.I): the regressor, its rank, what it predicts, and what unknown frames leave."""

from dataclasses import replace

import numpy as np
import pytest

from expdesign.errors import InputError
from expdesign.mechanics.elastostatics.arm_calibration import regressor_for
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.problem import DesignProblem
from tests.cases import robot
from tests.design.problems import BIPOD, HEXAPOD, designs, problem
from tests.oracle import Array, central_difference

GEOMETRIC = {
    "experiment.calibration": "geometric",
    "experiment.measurements": 24,
    "experiment.load": ...,
    "experiment.load_error": [],
    "experiment.poses.bounds.rz_rad": [-0.2, 0.2],
    "targets": [{"pose": [0.02, 0.01, 0.0, 0.05, -0.03, 0.1], "tolerance": {"dx_m": 1e-6, "drz_rad": 1e-5}}],
}


def assessed(here: DesignProblem, seed: int = 0) -> Assessment:
    return here.assess(*here.space.decode(designs(here, 1, seed)))


def moved(here: ParallelRobot, poses: Array, errors: Array) -> Array:
    """True poses at commanded poses (..., n) with geometric errors (..., p): q(X; g + δg) = q_cmd + δl."""
    joints, lengths = errors[..., : len(here.geometry)], errors[..., len(here.geometry) :]
    return here.pose_of(here.lengths(poses) + lengths, poses, here.geometry + joints)


@pytest.mark.parametrize("base", ["hexapod", "bipod"])
def test_the_regressor_is_the_derivative_of_the_true_pose(base: str) -> None:
    here = problem(HEXAPOD, GEOMETRIC) if base == "hexapod" else problem(BIPOD, {"experiment.calibration": "both"})
    robot_here = here.loaded.robot
    assert isinstance(robot_here, ParallelRobot)
    poses = here.space.decode(designs(here, 1))[0][0, 0]
    matrix = here.loaded.measure(poses, np.zeros(len(here.loaded.load.columns))).observation
    nominal = np.zeros(len(robot_here.geometry) + len(robot_here.stiffness))
    expected = central_difference(lambda errors: moved(robot_here, poses, errors), nominal, 1e-6)
    np.testing.assert_allclose(matrix[:, : len(nominal)], expected, atol=1e-7)


def test_a_hexapod_has_42_parameters_and_24_poses_identify_them() -> None:
    here = problem(HEXAPOD, GEOMETRIC)
    assert len(here.loaded.regressor.names(here.loaded.robot)) == 42
    assert int(assessed(here).rank[0]) == 42
    few = problem(HEXAPOD, {**GEOMETRIC, "experiment.measurements": 6})
    assert int(assessed(few).rank[0]) == 36
    assert not assessed(few).identifies_targets[0]
    assert np.isnan(known_criteria()["duir"].values(assessed(few)))[0]


def test_the_error_after_calibration_has_the_covariance_u() -> None:
    """Nonlinear: wrong joints, noisy poses, least squares, compensated command; within 4/√(2N) on each axis."""
    here = problem(HEXAPOD, GEOMETRIC)
    robot_here, samples = here.loaded.robot, 3000
    assert isinstance(robot_here, ParallelRobot)
    generator = np.random.default_rng(3)
    truth = 1e-4 * generator.standard_normal(42)
    poses = here.space.decode(designs(here, 1))[0]
    assessment = here.assess(poses, np.zeros((1, 24, 6)))
    exact = moved(robot_here, poses[0], truth)
    # What 1e-4 m leaves out of the linear regressor (1e-3 of 1e-4 m) is a bias here, the same in all samples.
    noise = generator.standard_normal((samples, 24, 6)) * np.sqrt(np.diag(here.noise.covariance))
    found = np.einsum("ipk,sik->sp", assessment.gain[0], exact - poses[0] + noise)
    target = here.targets.configurations[0]
    wanted = here.targets.observation[0]
    commands = target - found @ wanted.T
    attained = moved(robot_here, commands, np.broadcast_to(truth, (samples, 42)))
    measured = np.cov((attained - target).T)
    expected = assessment.noise_root[0, 0] @ assessment.noise_root[0, 0].T
    ratio = np.sqrt(np.diag(measured) / np.diag(expected))
    assert np.abs(ratio - 1.0).max() < 4.0 / np.sqrt(2 * samples)
    correlation = measured / np.sqrt(np.outer(np.diag(measured), np.diag(measured)))
    predicted = expected / np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert np.abs(correlation - predicted).max() < 4.0 / np.sqrt(samples)


def test_unknown_frames_change_no_prediction_of_what_the_instrument_will_read() -> None:
    known = problem(HEXAPOD, GEOMETRIC)
    unknown = problem(HEXAPOD, {**GEOMETRIC, "experiment.frames": "unknown"})
    first, second = assessed(known), assessed(unknown)
    assert second.parameters == 54
    assert int(second.rank[0]) == 42
    assert second.estimable.all()
    np.testing.assert_allclose(second.noise_variance, first.noise_variance, rtol=1e-6)


def test_the_pose_in_the_robots_own_frame_is_not_estimable_with_unknown_frames() -> None:
    here = problem(HEXAPOD, {**GEOMETRIC, "experiment.frames": "unknown"})
    rows = here.targets.observation.copy()
    rows[..., :12] = 0.0
    own = replace(here, targets=replace(here.targets, observation=rows))
    assert not assessed(own).estimable.any()
    # The difference of two instruments' readings at the same pose is nothing, and is estimable.
    nothing = replace(here, targets=replace(here.targets, observation=0.0 * rows))
    assert assessed(nothing).estimable.all()


def test_a_displaced_frame_is_a_displacement_of_all_its_joints() -> None:
    here = problem(HEXAPOD, {**GEOMETRIC, "experiment.frames": "unknown"})
    poses = here.space.decode(designs(here, 1))[0][0]
    matrix = here.loaded.measure(poses, np.zeros((24, 6))).observation
    hexapod = here.loaded.robot
    for axis in range(3):
        joints = np.zeros((6, 3))
        joints[:, axis] = 1.0
        turned = np.cross(np.eye(3)[axis], hexapod.base_joints)  # type: ignore[attr-defined]
        np.testing.assert_allclose(matrix[:, :, axis], matrix[:, :, 12:30] @ joints.ravel(), atol=1e-10)
        np.testing.assert_allclose(matrix[:, :, 3 + axis], matrix[:, :, 12:30] @ turned.ravel(), atol=1e-10)
        # Joints farther out on the platform bring the platform's frame back the other way.
        np.testing.assert_allclose(matrix[:, :, 6 + axis], -matrix[:, :, 30:48] @ joints.ravel(), atol=1e-10)


def test_both_together_are_the_two_side_by_side() -> None:
    changes = {"experiment.calibration": "both", "experiment.measurements": 12}
    both, plain = problem(HEXAPOD, changes), problem(HEXAPOD, {"experiment.measurements": 12})
    poses, loads = both.space.decode(designs(both, 1))
    stacked = both.loaded.measure(poses, loads).observation
    np.testing.assert_array_equal(stacked[..., 42:], plain.loaded.measure(poses, loads).observation)
    assert int(both.assess(poses, loads).rank[0]) == 48
    duir = known_criteria()["duir"]
    # More unknowns, never less uncertainty (the compliances alone are the case of a geometry that is known).
    assert duir.values(both.assess(poses, loads)) > duir.values(plain.assess(poses, loads))


def test_load_errors_do_not_reach_a_geometric_calibration() -> None:
    here = problem(HEXAPOD, GEOMETRIC)
    assert known_criteria()["feir"].values(assessed(here))[0] == 0.0


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"experiment.calibration": "geometric"}, "without load"),
        ({**GEOMETRIC, "targets": HEXAPOD["targets"]}, "at a target"),
        ({**GEOMETRIC, "experiment.reference_pose": {"pose": [0.0] * 6}}, "reference poses are for deflections"),
        ({"experiment.frames": "unknown"}, "unknown frames cancel"),
        ({"experiment.calibration": "both", "experiment.load": ...}, "the key is missing"),
        ({"experiment.calibration": "both", "experiment.deflection_noise.shared_reference": True}, "no unloaded"),
        ({"experiment.calibration": "kinematic"}, "not known here"),
    ],
)
def test_contradictions_are_named(changes: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        problem(HEXAPOD, changes)


def test_unknown_frames_need_orientations() -> None:
    with pytest.raises(InputError, match="six pose coordinates"):
        problem(BIPOD, {"experiment.calibration": "both", "experiment.frames": "unknown"})


def test_a_regressor_scales_like_its_parameters() -> None:
    here = robot("H1")
    for calibration in ("elastostatic", "geometric", "both"):
        regressor = regressor_for(calibration)
        sizes = {len(regressor.names(here)), len(regressor.scale(here)), len(regressor.nominal(here))}
        assert len(sizes) == 1
        assert (regressor.scale(here) > 0.0).all()
