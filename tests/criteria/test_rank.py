"""What cannot be identified is said to be so, and what can is right although other things cannot."""

from dataclasses import replace

import numpy as np
import pytest

from expdesign.mechanics.elastostatics.maps import observation_matrix
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.loads.load import Wrench
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.criteria.targets import Targets
from expdesign.planning.deflection_noise import DeflectionNoise
from tests import oracle
from tests.cases import ALL_ERRORS, ROBOTS, robot, setup
from tests.oracle import Array


def wrench_for(name: str, pose: Array, forces: Array) -> Array:
    """The wrench that puts the given forces into the actuators: F = J⁻ᵀτ."""
    return np.linalg.solve(robot(name).jacobians(pose).forward.T, forces)


def assess(
    name: str, poses: Array, wrenches: Array, target: tuple[Array, Array], noise: DeflectionNoise, importance: Array
) -> Assessment:
    """Designs (b, m, n) under wrenches for one target."""
    here = robot(name)
    observation = observation_matrix(here.jacobians(target[0]), target[1])
    targets = Targets(target[0][None], observation[None], importance[None], np.ones(1), here.coordinates.translations)
    return Assessment(LoadedRobot(here, Wrench(here.coordinates)).measure(poses, wrenches), noise, (), targets)


def test_target_that_needs_what_is_not_identified() -> None:
    pose, target = np.array([-0.2, 0.55]), np.array([0.1, 0.6])
    noise = DeflectionNoise.from_deviations(np.arange(2), np.full(2, 1e-6))
    load = wrench_for("bipod", pose, np.array([-700.0, 0.0]))
    found = assess("bipod", pose[None, None], load[None, None], (target, np.array([0.0, -1000.0])), noise, np.ones(2))
    assert not found.identifies_targets[0]
    for values in (found.noise_variance, found.force_variance, found.noise_root, found.force_sensitivity()):
        assert np.isnan(values).all()
    for name in ("duir", "feir", "total", "o_tp", "o_mv", "o_mv_max"):
        assert np.isnan(known_criteria()[name].values(found)[0])


def test_one_axis_of_a_target_can_be_identified_and_the_other_not() -> None:
    """Straight above base point 1, leg 2 moves the tool sideways only: y needs leg 1 alone, x needs both."""
    pose, target = np.array([-0.2, 0.55]), np.array([-0.5, 0.7])
    noise = DeflectionNoise.from_deviations(np.arange(2), np.full(2, 1e-6))
    load = wrench_for("bipod", pose, np.array([-700.0, 0.0]))
    wanted = np.array([100.0, -1000.0])
    for importance, identified in (([1.0, 1.0], False), ([0.0, 1e12], True), ([1.0, 0.0], False)):
        found = assess("bipod", pose[None, None], load[None, None], (target, wanted), noise, np.array(importance))
        np.testing.assert_array_equal(found.estimable[0, 0], [False, True])
        assert bool(found.identifies_targets[0]) is identified
        assert np.isnan(found.noise_variance[0, 0, 0])
        assert np.isnan(known_criteria()["duir"].values(found)[0]) is np.bool_(not identified)
    column = robot("bipod").jacobians(pose).pose[:, 0] * -700.0 / 1e-6
    expected = observation_matrix(robot("bipod").jacobians(target), wanted)[1, 0] ** 2 / (column @ column)
    assert found.noise_variance[0, 0, 1] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("name", [name for name in ROBOTS if not name.startswith("bipod")])
def test_five_identified_legs_of_six(name: str) -> None:
    """Leg 4 is never loaded: the same numbers as from a model without it."""
    generator = np.random.default_rng(3)
    poses, target = ROBOTS[name].poses(generator, 3), ROBOTS[name].poses(generator)
    forces = generator.uniform(-1.0, 1.0, (4, 6)) * 9.81 * ROBOTS[name].mass
    forces[:, 3] = 0.0
    wrenches = np.array([wrench_for(name, pose, tau) for pose, tau in zip(poses, forces[:3], strict=True)])
    wanted = wrench_for(name, target, forces[3])
    noise = DeflectionNoise.from_deviations(np.arange(6), np.array(ROBOTS[name].deviation))
    found = assess(name, poses[None], wrenches[None], (target, wanted), noise, np.ones(6))
    assert found.rank[0] == 5
    assert found.identifies_targets[0]
    assert found.condition[0] == np.inf
    for criterion in ("o1", "o2", "o3", "o4", "o5"):
        assert known_criteria()[criterion].values(found)[0] == 0.0
    kept = [0, 1, 2, 4, 5]
    expected = oracle.dense(
        oracle.observation(robot(name), poses, wrenches)[..., kept],
        oracle.compliance(robot(name), poses),
        noise.covariance,
        noise.axes,
        np.arange(3),
        False,
        [],
        oracle.observation(robot(name), target, wanted)[None][..., kept],
    )
    np.testing.assert_allclose(found.noise_variance[0, 0], np.diag(expected.noise[0]), rtol=1e-6)
    z = expected.sensitivity[0]
    np.testing.assert_allclose(found.force_sensitivity()[0, 0], z, rtol=1e-6, atol=1e-7 * np.abs(z).max(axis=1).min())


def test_weakly_loaded_leg_is_expensive_and_not_truncated() -> None:
    """m = 1: U grows as the inverse square of the leg's force over six decades, as the closed form says."""
    pose, target = np.array([-0.2, 0.55]), np.array([0.1, 0.6])
    noise = DeflectionNoise.from_deviations(np.arange(2), np.full(2, 1e-6))
    wanted = np.array([0.0, -1000.0])
    weak = np.array([1e2, 1e0, 1e-2, 1e-4])
    loads = np.array([[wrench_for("bipod", pose, np.array([-700.0, tau]))] for tau in weak])
    found = assess("bipod", np.tile(pose, (4, 1, 1)), loads, (target, wanted), noise, np.ones(2))
    here = robot("bipod")
    tau_d = here.jacobians(target).forward.T @ wanted
    for index, tau in enumerate(weak):
        ratio = np.diag(tau_d / np.array([-700.0, tau]))
        theta = here.jacobians(target).pose @ ratio @ np.linalg.inv(here.jacobians(pose).pose)
        np.testing.assert_allclose(found.noise_variance[index, 0], 1e-12 * np.diag(theta @ theta.T), rtol=1e-6)
    assert found.identifies_targets.all()


def test_designs_without_load_or_with_too_few_readings_identify_nothing() -> None:
    generator = np.random.default_rng(5)
    poses, wrenches = ROBOTS["H1"].poses(generator, 3, 1), ROBOTS["H1"].wrenches(generator, 3, 1)
    wrenches[1] = 0.0
    target = (ROBOTS["H1"].poses(generator), ROBOTS["H1"].wrenches(generator))
    vertical = DeflectionNoise.from_deviations(np.array([2]), np.array([1e-6]))
    found = assess("H1", poses, wrenches, target, vertical, np.ones(6))
    np.testing.assert_array_equal(found.rank, [1, 0, 1])
    assert not found.identifies_targets.any()
    assert np.isnan(known_criteria()["duir"].values(found)).all()


def test_deficient_and_singular_designs_leave_the_others_of_a_batch_alone() -> None:
    here = setup("bipod", "wrench", "deviations", ALL_ERRORS)
    generator = np.random.default_rng(6)
    poses, wrenches, series = here.designs(generator, 5, 3)
    poses[1, 2] = [0.1, 0.0]  # the legs are in line
    poses[3] = [-0.2, 0.55]
    wrenches[3] = wrench_for("bipod", poses[3, 0], np.array([-700.0, 0.0]))
    found = here.assess(poses, wrenches, series)
    good = [0, 2, 4]
    alone = here.assess(poses[good], wrenches[good], series[good])
    for name, criterion in known_criteria().items():
        values = criterion.values(found)
        np.testing.assert_allclose(values[good], criterion.values(alone), rtol=1e-10, err_msg=name)
        assert np.isnan(values[1]), name
    np.testing.assert_array_equal(found.identifies_targets, [True, False, True, False, True])
    np.testing.assert_array_equal(found.rank, [2, 0, 2, 1, 2])
    for values in (found.noise_variance, found.force_variance, found.force_sensitivity()):
        assert np.isnan(values[1]).all()
        assert np.isnan(values[3]).all()


def test_rank_does_not_depend_on_the_units_of_the_actuators() -> None:
    """Compliances that differ by six decades, as of joints in rad/(N·m) and legs in m/N."""
    here = setup("H1", "wrench")
    poses, wrenches, series = here.designs(np.random.default_rng(7), 2, 4)
    units = 10.0 ** np.array([-3.0, 3.0, 0.0, 2.0, -2.0, 1.0])
    measured = here.loaded.measure(poses, wrenches)
    scaled = replace(measured, observation=measured.observation * units)
    targets = replace(here.targets, observation=here.targets.observation * units)
    found = Assessment(scaled, here.noise, (), targets, series)
    np.testing.assert_array_equal(found.rank, [6, 6])
    expected = here.assess(poses, wrenches, series).noise_variance
    np.testing.assert_allclose(found.noise_variance, expected, rtol=1e-8)
