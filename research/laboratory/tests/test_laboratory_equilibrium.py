"""Without elements the engine's equilibria are those of theory.md 2, up to the change of geometry under load."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("exudyn", reason="the virtual laboratory needs the engine exudyn")
from research.laboratory import Laboratory

HEXAPOD_POSES = [
    [0, 0, 0, 0, 0, 0],
    [0.02, -0.01, 0.005, 0.05, -0.08, 0.1],
    [-0.03, 0.03, -0.02, 0.15, 0.15, 0.2],
    [0.03, 0, 0.02, -0.15, 0.1, -0.2],
]
BIPOD_POSES = [[0.1, 0.6], [-0.3, 0.35], [0.3, 0.95]]
CASES = [
    ("H1", 26.5, "fixed-xyz"),
    ("H1", 26.5, "moving-xyz"),
    ("H-large", 120.0, "fixed-xyz"),
    ("H-large", 120.0, "moving-xyz"),
    ("bipod", 100.0, "fixed-xyz"),
]
COM = np.array([0.03, 0.02, 0.15])
LEVER = 0.2  # m, to weigh rotations against translations


def size(deflection):
    return np.linalg.norm(np.concatenate([deflection[:3], LEVER * deflection[3:]]))


def wrench_of(bench, robot, pose, mass):
    force = mass * robot.gravity
    if robot.planar:
        return force[:2]
    return np.concatenate([force, np.cross(bench.rotation(np.array(pose[3:]), robot.orientation) @ COM, force)])


def poses_of(name):
    return BIPOD_POSES if name == "bipod" else HEXAPOD_POSES


@pytest.mark.parametrize(("name", "mass", "orientation"), CASES)
def test_payload_deflection_is_the_linear_one(bench, name, mass, orientation):
    robot = bench.robot(name, orientation=orientation)
    rows = bench.frame(poses_of(name), mass_kg=mass, com_x_m=COM[0], com_y_m=COM[1], com_z_m=COM[2])
    for pose, measured in zip(poses_of(name), bench.measure(robot, rows), strict=True):
        linear = bench.Linear(robot, pose).deflection(wrench_of(bench, robot, pose, mass))
        assert size(measured - linear) < 5e-4 * size(measured)


@pytest.mark.parametrize("name", ["H1", "bipod"])
def test_wrench_and_payload_say_the_same(bench, name):
    robot = bench.robot(name)
    pose = poses_of(name)[1]
    payload = bench.frame(pose, mass_kg=20.0, com_x_m=COM[0], com_y_m=COM[1], com_z_m=COM[2])
    wrench = bench.frame(pose, **bench.wrenches(wrench_of(bench, robot, pose, 20.0)))
    first, second = bench.measure(robot, payload)[0], bench.measure(robot, wrench)[0]
    assert size(first - second) < 1e-4 * size(first)  # the payload turns with the platform, the wrench does not


def test_published_test_vector(bench):
    robot = bench.robot("H1", actuator_stiffness=[5e6] * 6)
    rows = bench.frame(HEXAPOD_POSES[1], **bench.wrenches([20, -30, -300, 10, 5, -2]))
    expected = [11.13046734e-6, -10.77910351e-6, -14.20240261e-6, 34.34103804e-6, 0.71576148e-6, -2.52866346e-6]
    assert size(bench.measure(robot, rows)[0] - expected) < 5e-4 * size(np.array(expected))


@pytest.mark.parametrize("name", ["H1", "bipod"])
def test_small_loads_superpose_and_the_rest_grows_with_the_square(bench, name):
    robot = bench.robot(name)
    pose = poses_of(name)[2]
    wrench = np.array([30.0, -200.0]) if robot.planar else np.array([20.0, -30, -300, 10, 5, -2])
    scales = np.array([1.0, 0.5, 0.25])
    rows = bench.frame([pose] * 3, **bench.wrenches(scales[:, None] * wrench))
    linear = bench.Linear(robot, pose).deflection(wrench)
    errors = [size(m - s * linear) for m, s in zip(bench.measure(robot, rows), scales, strict=True)]
    assert errors[1] / errors[0] == pytest.approx(0.25, rel=0.05)
    assert errors[2] / errors[1] == pytest.approx(0.25, rel=0.05)


@pytest.mark.parametrize("name", ["H1", "H-large", "bipod"])
def test_leg_forces_balance_the_load(bench, name):
    """Force balance in the loaded geometry, with the deflection found: the residual of Newton's method."""
    robot = bench.robot(name)
    poses = poses_of(name)
    wrench = np.array([100.0, -1000.0]) if robot.planar else np.array([100.0, -50, -1000, 20, 10, -30])
    states = Laboratory(robot).states(bench.frame(poses, **bench.wrenches(wrench)))
    for attained, forces in zip(states.platform, states.leg_forces, strict=True):
        loaded = bench.Linear(robot, attained)
        assert loaded.J_inverse.T @ forces == pytest.approx(wrench, abs=1e-6)
        assert np.abs(loaded.tau(wrench) - forces).max() < 1e-5


def test_work_of_the_load_is_the_energy_of_the_springs(bench):
    robot = bench.robot("H1")
    pose, wrench = HEXAPOD_POSES[1], np.array([20.0, -30, -300, 10, 5, -2])
    states = Laboratory(robot).states(bench.frame(pose, **bench.wrenches(wrench)))
    deflection = states.platform[0] - states.unloaded[0]
    twist = np.concatenate([deflection[:3], bench.euler_rates(np.array(pose[3:]), robot.orientation) @ deflection[3:]])
    energy = np.sum(states.leg_forces[0] ** 2 / robot.actuator_stiffness) / 2
    assert wrench @ twist / 2 == pytest.approx(energy, rel=3e-4)


def test_geometric_stiffness_shows_under_tonnes(bench):
    """theory.md 2.3: the deflection is (K_C + K_G)^-1 F; soft legs stand for very large loads."""
    robot = bench.robot("bipod", actuator_stiffness=[1e5, 1e5])
    pose, wrench = [0.0, 0.6], np.array([20.0, 0.0])
    preload = np.array([0.0, -3000.0])
    rows = bench.frame([pose] * 2, **bench.wrenches([preload + wrench, preload - wrench]))
    attained = Laboratory(robot).states(rows).platform
    loaded = bench.Linear(robot, attained.mean(axis=0))
    elastic = loaded.J_inverse.T @ np.diag(robot.actuator_stiffness) @ loaded.J_inverse
    stiffness = elastic + loaded.geometric_stiffness(preload)
    found = (attained[0] - attained[1]) / 2
    assert found == pytest.approx(np.linalg.solve(stiffness, wrench), rel=1e-3, abs=1e-8)
    assert abs(found[0] / np.linalg.solve(elastic, wrench)[0] - 1) > 0.02


def test_unloaded_robot_is_where_it_is_commanded(bench):
    for name in ("H1", "bipod"):
        rows = bench.frame(poses_of(name), **bench.wrenches(np.zeros(2 if name == "bipod" else 6)))
        laboratory = Laboratory(bench.robot(name))
        assert laboratory.attained(rows).to_numpy() == pytest.approx(np.array(poses_of(name), dtype=float), abs=1e-14)


def test_attained_takes_poses_or_leg_lengths(bench):
    robot = bench.robot("H1")
    load = bench.wrenches([20, -30, -300, 10, 5, -2])
    rows = bench.frame(HEXAPOD_POSES, **load)
    for leg in range(6):
        rows[f"leg{leg + 1}_m"] = [bench.Linear(robot, pose).q[leg] for pose in HEXAPOD_POSES]
    laboratory = Laboratory(robot)
    by_pose, by_length = laboratory.attained(rows), laboratory.attained(rows, lengths=True)
    assert by_length.to_numpy() == pytest.approx(by_pose.to_numpy(), abs=1e-13)
    deflection = by_pose.to_numpy() - laboratory.attained(rows, loaded=False).to_numpy()
    assert deflection == pytest.approx(bench.measure(robot, rows), abs=1e-15)


def test_loaded_reference(bench):
    """With `abs_...` columns the wrench columns are changes from a reference that was itself loaded."""
    robot = bench.robot("H1")
    change, whole = np.array([0.0, 0, -200, 5, 0, 0]), np.array([10.0, 0, -500, 5, 20, 0])
    rows = bench.frame(HEXAPOD_POSES[1], **bench.wrenches(change))
    for name, value in bench.wrenches(whole).items():
        rows[f"abs_{name}"] = value
    both = bench.frame([HEXAPOD_POSES[1]] * 2, **bench.wrenches([whole, whole - change]))
    first, second = bench.measure(robot, both)
    assert bench.measure(robot, rows)[0] == pytest.approx(first - second, abs=1e-13)


def test_gravity_of_a_row(bench):
    robot = bench.robot("H1")
    down = bench.frame(HEXAPOD_POSES[0], mass_kg=10.0)
    sideways = bench.frame(HEXAPOD_POSES[0], mass_kg=10.0, gx_m_s2=9.80665, gy_m_s2=0.0, gz_m_s2=0.0)
    expected = bench.Linear(robot, HEXAPOD_POSES[0]).deflection([98.0665, 0, 0, 0, 0, 0])
    assert size(bench.measure(robot, sideways)[0] - expected) < 5e-4 * size(expected)
    assert abs(bench.measure(robot, down)[0][0]) < 1e-9


def test_loaded_reference_of_a_payload(bench):
    """The reference is the whole load less the payload, moment included."""
    robot = bench.robot("H1")
    pose = HEXAPOD_POSES[1]
    added = wrench_of(bench, robot, pose, 20.0)
    rows = bench.frame(pose, mass_kg=20.0, com_x_m=COM[0], com_y_m=COM[1], com_z_m=COM[2])
    for name, value in bench.wrenches(added).items():
        rows[f"abs_{name}"] = value  # the reference carries nothing
    plain = bench.frame(pose, **bench.wrenches(added))
    assert bench.measure(robot, rows)[0] == pytest.approx(bench.measure(robot, plain)[0], abs=1e-12)
