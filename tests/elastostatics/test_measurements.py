"""The linear model of measurements: maps and load errors put together, with the geometric stiffness as an option."""

import numpy as np
import pytest
from tests import oracle
from tests.cases import ALL_ERRORS, ROBOTS, load_of, loads, robot, setup
from tests.oracle import Array

from expdesign.mechanics.elastostatics.geometric_stiffness import conservative_maps
from expdesign.mechanics.elastostatics.measurements import LoadedRobot


@pytest.mark.parametrize("kind", ["payload", "wrench"])
@pytest.mark.parametrize("name", ROBOTS)
def test_measurements_are_those_of_the_hand_formulas(name: str, kind: str) -> None:
    loaded = setup(name, kind, errors=ALL_ERRORS).loaded
    generator = np.random.default_rng(0)
    poses, parameters = ROBOTS[name].poses(generator, 2, 3), loads(name, kind, generator, 2, 3)
    found = loaded.measure(poses, parameters)
    turned = oracle.kinematics(robot(name), poses).rotation
    wrenches = oracle.load_wrench(kind, parameters, turned)
    expected = oracle.observation(robot(name), poses, wrenches)
    np.testing.assert_allclose(found.observation, expected, rtol=1e-9, atol=1e-10 * np.abs(expected).max())
    assert found.jacobians.condition.shape == (2, 3)
    for source, columns in zip(loaded.sources, found.sources, strict=True):
        error = found.load_errors[..., columns]
        for index in np.ndindex(2, 3):
            by_hand = oracle.sensitivity(source.source, kind, parameters[index], turned[index]) * source.deviation
            np.testing.assert_allclose(error[index], by_hand, rtol=1e-10, atol=1e-11 * np.abs(by_hand).max())


@pytest.mark.parametrize("name", ["bipod", "irregular"])
def test_geometric_stiffness_is_an_option(name: str) -> None:
    here = robot(name)
    loaded = LoadedRobot(here, load_of("payload", here.coordinates), geometric_stiffness=True)
    generator = np.random.default_rng(1)
    poses, parameters = ROBOTS[name].poses(generator, 4), loads(name, "payload", generator, 4)
    jacobians = here.jacobians(poses)
    wrenches, _ = loaded.wrenches(jacobians.rotation, parameters)
    observation, compliance = conservative_maps(here, poses, jacobians, wrenches)
    found = loaded.measure(poses, parameters)
    np.testing.assert_array_equal(found.observation, observation)
    np.testing.assert_array_equal(found.compliance, compliance)
    without = LoadedRobot(here, loaded.load).measure(poses, parameters)
    assert 0.0 < np.abs(found.observation / without.observation - 1.0).max() < 0.1


@pytest.mark.parametrize("geometric_stiffness", [False, True])
def test_a_singular_measurement_is_infinite_and_not_a_number_and_spares_the_others(geometric_stiffness: bool) -> None:
    here = robot("bipod")
    loaded = LoadedRobot(here, load_of("wrench", here.coordinates), geometric_stiffness=geometric_stiffness)
    poses: Array = np.array([[0.1, 0.6], [0.1, 0.0], [-0.2, 0.5]])
    parameters = np.tile([100.0, -900.0], (3, 1))
    found = loaded.measure(poses, parameters)
    assert found.jacobians.condition[1] == np.inf
    assert np.isnan(found.observation[1]).all()
    assert np.isnan(found.compliance[1]).all()
    alone = loaded.measure(poses[[0, 2]], parameters[[0, 2]])
    np.testing.assert_allclose(found.observation[[0, 2]], alone.observation, rtol=1e-13)
    np.testing.assert_allclose(found.compliance[[0, 2]], alone.compliance, rtol=1e-13)
