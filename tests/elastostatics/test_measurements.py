"""The linear model of measurements: maps and load errors put together, with the geometric stiffness as an option."""

import numpy as np
import pytest

from expdesign.chain.chain import Chain
from expdesign.chain.component import GEOMETRY
from expdesign.chain.effects.legs.geometry import MAPPING, GeometricStiffness
from expdesign.mechanics.elastostatics.maps import actuator_forces, cartesian_stiffness
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.planning.linearised import KnownChain
from tests import oracle
from tests.cases import ALL_ERRORS, ROBOTS, load_of, loads, robot, setup
from tests.oracle import Array, central_difference


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


def mapped(here: ParallelRobot) -> KnownChain:
    """The conservative mapping, as `experiment.geometric_stiffness` puts it into a plan."""
    chain = Chain(here, (GeometricStiffness(here, GEOMETRY, MAPPING),))
    return KnownChain(chain, np.ones(len(chain.parameters)))


@pytest.mark.parametrize("name", ["bipod", "irregular"])
def test_maps_with_geometric_stiffness_are_derivatives_of_the_conservative_mapping(name: str) -> None:
    """ΔX = (K_C + K_G)⁻¹·ΔF (theory.md 2.3), and both maps against central differences of it."""
    here = robot(name)
    generator = np.random.default_rng(1)
    poses, wrenches = ROBOTS[name].poses(generator, 4), loads(name, "wrench", generator, 4)
    jacobians = here.jacobians(poses)

    def deflection(compliance: Array, wrench: Array) -> Array:
        total = cartesian_stiffness(jacobians, compliance) + oracle.geometric_stiffness(
            here, poses, actuator_forces(jacobians, wrench)
        )
        return np.linalg.solve(total, wrench[..., None])[..., 0]

    loaded = LoadedRobot(here, load_of("wrench", here.coordinates), physics=mapped(here))
    found = loaded.measure(poses, wrenches)
    none = np.zeros_like(wrenches)
    np.testing.assert_allclose(
        loaded.deflections(poses, wrenches, none), deflection(here.compliance, wrenches), rtol=1e-9
    )
    nominal = np.ones(len(here.compliance))
    by_share = central_difference(lambda share: deflection(share * here.compliance, wrenches), nominal, 1e-4)
    by_load = central_difference(lambda load: deflection(here.compliance, load), wrenches, 1e-3)
    for exact, expected, most in (
        (found.observation * here.compliance, by_share, 1e-6),
        (found.compliance, by_load, 1e-5),
    ):
        size = np.abs(expected).max(axis=(0, 1))
        assert (np.abs(exact - expected).max(axis=(0, 1)) < most * size).all()
    without = LoadedRobot(here, loaded.load).measure(poses, wrenches)
    assert 0.0 < np.abs(found.observation / without.observation - 1.0).max() < 0.1


@pytest.mark.parametrize("geometric_stiffness", [False, True])
def test_a_singular_measurement_is_infinite_and_not_a_number_and_spares_the_others(geometric_stiffness: bool) -> None:
    here = robot("bipod")
    physics = mapped(here) if geometric_stiffness else None
    loaded = LoadedRobot(here, load_of("wrench", here.coordinates), physics=physics)
    poses: Array = np.array([[0.1, 0.6], [0.1, 0.0], [-0.2, 0.5]])
    parameters = np.tile([100.0, -900.0], (3, 1))
    found = loaded.measure(poses, parameters)
    assert found.jacobians.condition[1] == np.inf
    assert np.isnan(found.observation[1]).all()
    assert np.isnan(found.compliance[1]).all()
    alone = loaded.measure(poses[[0, 2]], parameters[[0, 2]])
    np.testing.assert_allclose(found.observation[[0, 2]], alone.observation, rtol=1e-13)
    np.testing.assert_allclose(found.compliance[[0, 2]], alone.compliance, rtol=1e-13)
