"""Test vectors of theory.md 11 to their printed digits."""

import numpy as np
from tests.cases import robot

from expdesign.chain.instrument.deflection_noise import DeflectionNoise
from expdesign.mechanics.elastostatics.maps import (
    actuator_forces,
    cartesian_compliance,
    cartesian_stiffness,
    geometric_stiffness,
    observation_matrix,
)
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.loads.load import Wrench
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.criteria.targets import Targets

TARGET, TARGET_LOAD = np.array([0.10, 0.60]), np.array([0.0, -1000.0])
POSE, LOAD = np.array([-0.20, 0.55]), np.array([200.0, -900.0])


def assessment() -> Assessment:
    """One measurement with G = I, and the target."""
    here = robot("bipod")
    loaded = LoadedRobot(here, Wrench(here.coordinates))
    observation = loaded.measure(TARGET[None], TARGET_LOAD[None]).observation
    targets = Targets(TARGET[None], observation, np.ones((1, 2)), np.ones(1), 2)
    noise = DeflectionNoise.from_deviations(np.arange(2), np.ones(2))
    return Assessment(loaded.measure(POSE[None, None], LOAD[None, None]), noise, (), targets)


def test_target_maps() -> None:
    here = robot("bipod")
    jacobians = here.jacobians(TARGET)
    forces = actuator_forces(jacobians, TARGET_LOAD)
    np.testing.assert_allclose(forces, [-565.6854249, -721.1102551], atol=5e-8)
    observation = observation_matrix(jacobians, TARGET_LOAD)
    np.testing.assert_allclose(observation, [[-480.0, 520.0], [-320.0, -520.0]], rtol=1e-12)
    np.testing.assert_allclose(observation @ here.compliance, [-8e-6, -72e-6], rtol=1e-12)
    compliance = cartesian_compliance(jacobians, here.compliance)
    np.testing.assert_allclose(compliance, [[0.112e-6, 0.008e-6], [0.008e-6, 0.072e-6]], rtol=1e-12)
    stiffness = cartesian_stiffness(jacobians, here.compliance)
    np.testing.assert_allclose(stiffness, [[9e6, -1e6], [-1e6, 14e6]], rtol=1e-12)
    geometric = geometric_stiffness(here, TARGET, forces)
    np.testing.assert_allclose(geometric, [[-1025.641, -128.2051], [-128.2051, -641.0256]], atol=5e-4)


def test_measurement_maps() -> None:
    jacobians = robot("bipod").jacobians(POSE)
    expected = [-592.3255749812, -615.0643317828]
    np.testing.assert_allclose(actuator_forces(jacobians, LOAD), expected, atol=5e-11 * 1e3)
    expected_matrix = [[-371.0909090909, 547.5454545455], [-472.2975206612, -298.6611570248]]
    np.testing.assert_allclose(observation_matrix(jacobians, LOAD), expected_matrix, atol=5e-10)


def test_errors_at_the_target() -> None:
    found = assessment()
    noise = found.noise_root[0, 0] @ found.noise_root[0, 0].T
    np.testing.assert_allclose(noise, [[1.1442042521, -0.2390983402], [-0.2390983402, 1.1581359476]], atol=5e-11)
    np.testing.assert_allclose(found.noise_variance[0, 0], np.diag(noise), rtol=1e-14)
    expected = [[-0.1086639676, -0.0330364372], [0.0240485830, -0.0746558704]]
    np.testing.assert_allclose(1e6 * found.force_sensitivity()[0, 0], expected, atol=5e-11)
    assert abs(known_criteria()["o_tp"].values(found)[0] - 2.3023401997) < 1e-10


def test_observability_indices() -> None:
    found = assessment()
    values = [float(known_criteria()[f"o{i}"].values(found)[0]) for i in range(1, 6)]
    np.testing.assert_allclose(values, [607.811485, 0.842296, 557.829267, 469.857415, 302.790234], atol=5e-7)


def test_command_that_reaches_the_target() -> None:
    """X_C + A(X_C, ΔF_D)·c = X_D by the fixed point of theory.md 4.1."""
    here = robot("bipod")
    command = TARGET.copy()
    for _ in range(10):
        command = TARGET - observation_matrix(here.jacobians(command), TARGET_LOAD) @ here.compliance
    np.testing.assert_allclose(command, [0.100007997793, 0.600071992929], atol=5e-13)


def test_hexapod() -> None:
    pose = np.array([0.02, -0.01, 0.005, 0.05, -0.08, 0.1])
    wrench = np.array([20.0, -30.0, -300.0, 10.0, 5.0, -2.0])
    jacobians = robot("H1").jacobians(pose)
    expected = [-10.66789886, -34.51381196, -56.10004918, -44.03405159, -110.10498460, -85.55529200]
    np.testing.assert_allclose(actuator_forces(jacobians, wrench), expected, atol=5e-9)
    deflection = 1e6 * observation_matrix(jacobians, wrench) @ np.full(6, 1.0 / 5e6)
    expected = [11.13046734, -10.77910351, -14.20240261, 34.34103804, 0.71576148, -2.52866346]
    np.testing.assert_allclose(deflection, expected, atol=5e-9)
