"""The third source: bodies, curves and equilibria against closed formulas; every kind shows where it should."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

pytest.importorskip("skfem", reason="the third source needs the extra third-source")
from research.benchmarks.concealed.arms import base_deflections
from research.benchmarks.concealed.campaigns import JOINTS, POSE, WRENCH, base_matrices
from research.benchmarks.concealed.hexapods import posture
from research.benchmarks.concealed.third_source import arms, bodies, curves
from research.benchmarks.concealed.third_source.cases import draw_case
from research.benchmarks.concealed.third_source.hexapods import Machine, draw_hexapod
from research.benchmarks.concealed.third_source.kinds import KINDS

HEXAPOD = draw_hexapod(np.random.default_rng(2))
ARM = arms.draw_arm(np.random.default_rng(3))
LOAD = np.array([60.0, -40.0, -220.0, 6.0, -4.0, 3.0])
FORCE = np.array([6.0, -4.0, -9.0, 0.6, 0.3, -0.4])
COMMAND = np.array([0.3, -0.4, 1.1, 0.2, 0.7, -0.5])


def at_one_place(columns: tuple[str, ...], place: object, *loads: np.ndarray) -> pd.DataFrame:
    table = pd.DataFrame(np.array(loads), columns=list(WRENCH)).assign(series=1)
    table[list(columns)] = place
    return table


def rows(*loads: np.ndarray) -> pd.DataFrame:
    return at_one_place(POSE, [0.01, -0.01, 0.005, 0.04, -0.05, 0.06], *loads)


def arm_rows(*loads: np.ndarray) -> pd.DataFrame:
    return at_one_place(JOINTS, COMMAND, *loads)


def test_a_plate_bends_as_timoshenko_says() -> None:
    """Circular plate under a force at its centre: FR²(3 + ν)/16πD(1 + ν) when supported (Theory of Plates, eq. 88)."""
    centre = np.zeros((1, 3))
    supported = 3.3 / (16 * np.pi * 1.3)
    assert bodies.Plate(1.0).compliance(centre)[2, 2] == pytest.approx(supported, rel=0.01)
    half = bodies.Plate(0.5).compliance(centre)[2, 2]
    assert half == pytest.approx(supported / 4, rel=0.01)


def test_a_joint_above_a_plate_moves_sideways_as_the_plate_slopes() -> None:
    plate, there = bodies.Plate(1.0, hub=0.2), np.array([[0.8, 0.0, 0.05]])
    found = plate.compliance(there)
    outside = plate.compliance(there * [1.01, 1, 1])[2, 2] - plate.compliance(there * [0.99, 1, 1])[2, 2]
    assert found[0, 2] == pytest.approx(-0.05 * outside / 0.016 / 2, rel=0.02)  # d w(x, x)/dx = 2 w'
    np.testing.assert_allclose(found, found.T, atol=1e-9)


def test_a_slender_block_is_timoshenkos_beam() -> None:
    length, side = 1.0, 0.1
    found, inertia = bodies.block(length, side, side, 1.0), side**4 / 12
    shear = length / (side**2 * 5 / 6 / 2.6)
    assert found[0, 0] == pytest.approx(length**3 / 3 / inertia + shear, rel=0.03)
    assert found[0, 4] == pytest.approx(length**2 / 2 / inertia, rel=0.03)
    assert found[2, 2] == pytest.approx(length / side**2, rel=0.02)
    assert found[5, 5] == pytest.approx(length * 2.6 / (0.1406 * side**4), rel=0.03)


def test_a_wall_warms_through_as_the_series_says() -> None:
    """A step at one face: the mean lags by Σ 8/π²(2n+1)² exp(−(2n+1)²π²t/4); at the end the wall is straight again."""
    times = np.linspace(0, 6000, 300)
    mean, moment = bodies.wall(times, 20.0 + np.where(times > 0, 1.0, 0.0), 2000.0)
    odd = 2 * np.arange(40) + 1
    late = times > 300
    expected = 1 - (8 / np.pi**2 / odd**2 * np.exp(-np.outer(times[late] / 2000, odd**2 * np.pi**2 / 4))).sum(axis=1)
    np.testing.assert_allclose(mean[late], expected, atol=0.01)
    assert moment.min() < -0.5
    assert abs(moment[-1]) < 0.01


def test_a_bearing_is_unloaded_at_2_83_preloads() -> None:
    moved = curves.bearing_pair(0.4)
    assert moved(np.array(0.4)) == pytest.approx(1.0, rel=1e-4)
    assert moved(np.array(-0.4)) == pytest.approx(-1.0, rel=1e-4)
    assert moved(np.array(4.0)) == pytest.approx((4.0 / 0.4 * 2**1.5) ** (2 / 3) - 1, rel=1e-4)  # a single bearing
    slope = moved(np.array(1e-3)) / 1e-3
    assert slope == pytest.approx(1 / (3 * 0.4 / 2**1.5), rel=1e-3)


def test_a_film_carries_its_share_of_what_it_can() -> None:
    eccentricity = curves.hydrostatic(0.5, 0.9)
    assert 0.5 < eccentricity(np.array(1.0)) < 1.0
    assert eccentricity(np.array(-0.3)) == pytest.approx(-eccentricity(np.array(0.3)))


def test_presliding_friction_saturates_and_turns_back() -> None:
    """Dahl under growing displacement: F = limit·(1 − exp(−x/presliding)), with x = path − F."""
    path = np.array([0.0, 0.3, 1.0, 0.0])
    friction = curves.dahl(path, 0.1, 0.05, steps=2000)
    moved = path - friction
    np.testing.assert_allclose(friction[:3], 0.1 * (1 - np.exp(-moved[:3] / 0.05)), atol=1e-4)
    assert friction[3] == pytest.approx(-0.1, abs=1e-3)


def test_creep_goes_by_a_power_of_time_and_comes_back() -> None:
    times = np.array([0.0, 60.0, 120.0, 660.0, 720.0])
    found = curves.findley(np.array([0.0, 2.0, 2.0, 0.0, 0.0]), times, 0.25)
    np.testing.assert_allclose(found[1:3], 2.0 * np.array([54 / 60, 114 / 60]) ** 0.25)
    assert 0 < found[4] < found[3] < found[2]


def test_rubber_is_softer_once_it_was_loaded() -> None:
    found = curves.rubber(np.array([0.4, 1.0, 0.4, -0.4, 0.0]), 0.5, 0.3)
    assert found[2] > 1.1 * found[0]
    assert found[1] / 1.0 > found[0] / 0.4  # softer with amplitude
    assert found[3] == pytest.approx(-found[2])
    assert found[4] == 0.0


def test_a_cable_hangs_in_equilibrium() -> None:
    """Both ends carry the weight together; between ends of one height each carries half of it."""
    span = np.array([[2.0, 0.0, 0.0], [1.2, -0.9, 0.8]])
    there, back = curves.catenary(span, 3.0, 5.0), curves.catenary(-span, 3.0, 5.0)
    np.testing.assert_allclose((there + back)[:, 2], -15.0, rtol=1e-9)
    np.testing.assert_allclose((there + back)[:, :2], 0.0, atol=1e-9)
    assert there[0, 2] == pytest.approx(-7.5)
    a = -there[0, 0] / 5.0
    assert 2 * a * np.sinh(1.0 / a) == pytest.approx(3.0)


def test_a_mesh_has_two_levels() -> None:
    found = curves.mesh_compliance(np.linspace(0, 3, 601), 1.5)
    assert found.max() == pytest.approx(1.0, abs=1e-3)
    assert found.min() == pytest.approx(1 / 1.5, abs=1e-3)
    assert np.mean(found < 0.83) == pytest.approx(0.6, abs=0.02)


def test_healthy_machines_are_the_base_model() -> None:
    expected = base_matrices(HEXAPOD, rows(LOAD, -0.5 * LOAD)) @ (1.0 / HEXAPOD.stiffness)
    np.testing.assert_allclose(Machine(HEXAPOD).deflections(rows(LOAD, -0.5 * LOAD)), expected, rtol=1e-2, atol=2e-8)
    _, matrices = base_deflections(arms.Chain(ARM), arm_rows(FORCE, 0 * FORCE))
    found = arms.Chain(ARM).states(arm_rows(FORCE, 0 * FORCE)).deflections()
    np.testing.assert_allclose(found, matrices @ (1 / ARM.stiffness), rtol=0.03, atol=1e-6)


def test_a_spring_beside_the_legs_takes_its_share() -> None:
    """Compliances of the legs and of the ground's spring: (C⁻¹ + S)⁻¹ at small deflections."""
    place = posture(HEXAPOD, rows(LOAD)[list(POSE)].to_numpy()[0])
    legs = place.inverse_jacobian.T @ np.diag(HEXAPOD.stiffness) @ place.inverse_jacobian
    spring = np.diag([0.3, 0.3, 0.3, 0.05, 0.05, 0.05]) * HEXAPOD.stiffness.mean()
    moved = place.coordinates(np.linalg.solve(legs + spring, LOAD))
    found = Machine(HEXAPOD, spring=spring).deflections(rows(LOAD))[0]
    np.testing.assert_allclose(found, moved, rtol=0.02, atol=1e-8)


def test_a_pedestal_moves_the_arm_as_a_rigid_body() -> None:
    matrix = np.diag([0, 0, 0, 1 / 2e5, 1 / 3e5, 1 / 4e5])
    tilted = arms.Chain(ARM, arms.Concealing(yields={0: lambda wrench, table: wrench @ matrix.T}))
    table = arm_rows(FORCE)
    change = tilted.states(table).deflections() - arms.Chain(ARM).states(table).deflections()
    place, _, _ = arms.Chain(ARM).rigid(COMMAND)
    moment = (FORCE[3:] + np.cross(place, FORCE[:3])) / [2e5, 3e5, 4e5]
    np.testing.assert_allclose(change[0], [*np.cross(moment, place), *moment], rtol=0.03, atol=3e-7)


def test_a_spring_between_two_links_loads_the_joint_between_them_alone() -> None:
    line = arms.Line((1, 2), (np.array([0.2, 0, 0.3]), np.array([0, 0, 0.3])), lambda span: 200.0 * span)
    turned = [
        arms.Chain(ARM, conceals)._equilibrium(COMMAND[None], np.zeros((1, 6)), arm_rows(FORCE), None)[2][0]
        for conceals in (arms.Concealing(lines=(line,)), None)
    ]
    change = turned[0] - turned[1]
    assert abs(change[1]) > 1.0
    np.testing.assert_allclose(np.delete(change, 1), 0.0, atol=0.02)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_shows(kind: str) -> None:
    """It leaves 2 to 10 standard deviations beyond the base fit, and its places are parts of the machine."""
    case = draw_case((kind, False), np.random.default_rng([5, 7]))
    (effect,) = case.truth["effects"]
    assert 1.8 <= effect["mismatch_in_std"] <= 11.0
    joints = [f"{part} {n}" for part in ("leg", "joint", "link") for n in range(1, 7)]
    assert set(effect["parts"]) <= {*joints, "base", "platform", "payload", "environment", "instrument"}
    assert len(effect["parts"]) == len(KINDS[kind].places)
    assert KINDS[kind].size[1] <= effect["size"] <= KINDS[kind].size[2]
    if KINDS[kind].wishes.temperature:
        assert "temperature_degC" in case.recordings
