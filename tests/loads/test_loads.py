"""Wrenches of loads, and what load errors do to them, against exact finite disturbances."""

import numpy as np
import pytest

from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.loads.errors.source import LoadErrorSource
from expdesign.plugins import implementations
from tests import oracle
from tests.cases import ROBOTS, SOURCES, load_of, loads, robot, source_of
from tests.oracle import Array

KINDS = ["payload", "wrench"]


def rotations(name: str, count: int) -> Array:
    """Orientations of the platform at random poses."""
    return oracle.kinematics(robot(name), ROBOTS[name].poses(np.random.default_rng(1), count)).rotation


@pytest.mark.parametrize("name", ROBOTS)
def test_payload_is_its_weight_at_the_turned_centre_of_mass(name: str) -> None:
    here, turned = robot(name), rotations(name, 8)
    load = load_of("payload", here.coordinates)
    parameters = loads(name, "payload", np.random.default_rng(2), 8)
    wrench = load.wrenches(turned, parameters)
    np.testing.assert_allclose(wrench, oracle.payload_wrench(parameters, turned), rtol=1e-12, atol=1e-9)


def test_payload_with_numbers_that_can_be_checked_in_the_head() -> None:
    """10 kg, 0.1 m along x of a platform turned by 90° about z: its weight acts 0.1 m along y and turns about x."""
    here = robot("H1")
    turned = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    parameters = np.array([10.0, 0.1, 0.0, 0.0, *here.gravity])
    wrench = load_of("payload", here.coordinates).wrenches(turned, parameters)
    np.testing.assert_allclose(wrench, [0.0, 0.0, -98.0665, -9.80665, 0.0, 0.0], atol=1e-12)


def test_defaults_of_columns() -> None:
    payload, wrench = (load_of(kind, robot("H1").coordinates) for kind in KINDS)
    gravity = np.array([1.0, 2.0, 3.0])
    np.testing.assert_array_equal(payload.defaults(gravity), [np.nan, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0])
    np.testing.assert_array_equal(wrench.defaults(gravity), np.zeros(6))
    planar = load_of("payload", robot("bipod").coordinates)
    assert planar.columns == ("mass_kg", "gx_m_s2", "gy_m_s2")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ROBOTS)
def test_a_free_wrench_does_not_depend_on_the_pose(name: str, kind: str) -> None:
    """A payload's force does not either, but its moment does."""
    here = robot(name)
    parameters = np.tile(loads(name, kind, np.random.default_rng(3)), (8, 1))
    wrench = load_of(kind, here.coordinates).wrenches(rotations(name, 8), parameters)
    force = wrench[:, : len(here.home)]
    np.testing.assert_allclose(force, np.broadcast_to(force[0], force.shape), rtol=1e-14)
    moves = np.ptp(wrench, axis=0).max() > 1e-9
    assert moves == (kind == "payload" and here.coordinates.n == 6)


@pytest.mark.parametrize("source", SOURCES)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ROBOTS)
def test_sensitivity_is_the_derivative_of_the_exactly_disturbed_wrench(name: str, kind: str, source: str) -> None:
    here = robot(name)
    load = load_of(kind, here.coordinates)
    made = source_of(source, load, True)
    if made is None:
        assert (kind, source) in {("wrench", "mass"), ("wrench", "com"), ("payload", "com")}
        assert source != "com" or kind == "wrench" or here.coordinates.n == 2
        return
    turned, parameters = rotations(name, 6), loads(name, kind, np.random.default_rng(4), 6)
    (found,) = LoadedRobot(here, load, (made,)).load_errors(turned, parameters)
    assert found.shape == (6, here.coordinates.n, len(made.deviation))
    nothing = np.zeros((1, len(made.deviation)))
    slopes = oracle.central_difference(
        lambda delta: oracle.disturbed_wrench(source, kind, parameters, turned, delta), nothing, 1e-4
    )
    for column, expected in enumerate(np.moveaxis(slopes * made.deviation, -1, 0)):
        np.testing.assert_allclose(found[..., column], expected, rtol=1e-6, atol=1e-7 * np.abs(expected).max())


def test_com_error_of_the_theory() -> None:
    """theory.md 5.2: δMx = −m·g·δy, δMy = +m·g·δx and nothing along gravity (120 kg: 1176.8 N)."""
    here = robot("H-large")
    load = load_of("payload", here.coordinates)
    source = source_of("com", load, True)
    assert source is not None
    parameters = np.array([120.0, 0.0, 0.0, 0.2, 0.0, 0.0, -9.80665])
    (found,) = LoadedRobot(here, load, (source,)).load_errors(np.eye(3), parameters)
    weight = 1176.798
    expected = np.zeros((6, 3))
    expected[3, 1], expected[4, 0] = -weight, weight
    np.testing.assert_allclose(found / source.deviation, expected, atol=1e-9)


def test_every_source_of_the_package_is_in_the_table() -> None:
    known = {cls.source for cls in implementations("expdesign.mechanics.loads.errors", LoadErrorSource)}  # type: ignore[type-abstract]
    assert known == set(SOURCES)
