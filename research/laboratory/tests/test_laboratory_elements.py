"""Elements in limits with known answers, beside what tests/chain/test_against_laboratory.py compares with the chain."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

pytest.importorskip("exudyn", reason="the virtual laboratory needs the engine exudyn")
from research.laboratory import Laboratory, LaboratoryError
from research.laboratory import elements as el

POSE = [0.02, -0.01, 0.005, 0.05, -0.08, 0.1]
HOME = [0.0] * 6
WRENCH = np.array([20.0, -30, -300, 10, 5, -2])
NONE = np.zeros(6)


def close(found, expected, relative=1e-3, lever=0.2):
    """Whether two deflections agree relative to the size of the larger."""
    scale = np.array([1, 1, 1, lever, lever, lever])[: len(expected)]
    return np.linalg.norm((found - expected) * scale) <= relative * np.linalg.norm(np.asarray(expected) * scale)


def difference(bench, robot, rows, *elements):
    return bench.measure(robot, rows, *elements) - bench.measure(robot, rows)


def payload(bench, mass=20.0, com=(0.03, 0.02, 0.15), pose=POSE):
    return bench.frame(pose, mass_kg=mass, com_x_m=com[0], com_y_m=com[1], com_z_m=com[2])


def one(bench, wrench=WRENCH, pose=POSE):
    return bench.frame(pose, **bench.wrenches(wrench))


def series(bench, loads, pose=POSE, **columns):
    """One series: rows with these loads in this order."""
    loads = np.atleast_2d(loads)
    return bench.frame([pose] * len(loads), **bench.wrenches(loads), series=1, sequence=range(len(loads)), **columns)


# payload ------------------------------------------------------------------------------------------------


def test_payload_mass_error_scales(bench):
    robot = bench.robot("H1")
    wrong = bench.measure(robot, payload(bench), el.PayloadMassError(0.05))
    assert wrong == pytest.approx(bench.measure(robot, payload(bench, mass=21.0)), abs=1e-15)


# structure ----------------------------------------------------------------------------------------------


def test_compliant_base_of_a_bipod(bench):
    robot = bench.robot("bipod")
    wrench = np.array([50.0, -300.0])
    turn = (0.1 * wrench[1] - 0.6 * wrench[0]) / 2e6
    expected = wrench / [3e7, 4e7] + turn * np.array([-0.6, 0.1])
    rows = bench.frame([0.1, 0.6], **bench.wrenches(wrench))
    found = difference(bench, robot, rows, el.BaseCompliance([3e7, 4e7, 1e7, 1e6, 1e6, 2e6]))[0]
    assert close(found, expected)


# joints -------------------------------------------------------------------------------------------------


def test_passive_joint_stiffness_away_from_home(bench):
    """The flexures are free of moment at home; elsewhere they shift the unloaded pose but hardly the stiffness."""
    robot = bench.robot("H1")
    soft = bench.measure(robot, one(bench), el.PassiveJointStiffness(1e-3))[0]
    assert close(soft, bench.measure(robot, one(bench))[0], 1e-6)
    rows = one(bench, NONE)
    moved = Laboratory(robot, elements=[el.PassiveJointStiffness(100.0)]).attained(rows).to_numpy()[0] - POSE
    assert 1e-7 < np.abs(moved[:3]).max() < 1e-4


# legs ---------------------------------------------------------------------------------------------------


def leg_elongation(bench, robot, rows, leg, *elements):
    """Elongation of a leg in each row, from the deflections: row `leg` of the inverse modified Jacobian."""
    model = bench.Linear(robot, POSE)
    return bench.measure(robot, rows, *elements) @ model.J_check_inverse[leg]


def pure_leg_force(bench, robot, leg, force):
    """Wrenches under which only one leg carries: F = J^-T tau."""
    return np.outer(np.atleast_1d(force), bench.Linear(robot, POSE).J_inverse[leg])


def test_leg_floats_within_its_play(bench):
    """With flexures the platform has other ways to carry; a leg that does not reach the end of its gap is free."""
    robot = bench.robot("H1")
    stiff = el.PassiveJointStiffness(2e5)
    rows = one(bench, WRENCH, HOME)
    states = Laboratory(robot, elements=[stiff, el.LegBacklash("leg 3", 1e-3)]).states(rows)
    assert abs(states.leg_forces[0, 2]) < 1e-3
    assert np.abs(states.leg_forces[0, [0, 1, 3, 4, 5]]).min() > 0.1


def test_iwan_friction_is_soft_when_it_slides(bench):
    robot = bench.robot("H1")
    k = robot.actuator_stiffness[1]
    element = el.FrictionHysteresis("leg 2", 6.0, contact_N_per_m=3 * k, sliders=3)
    rows = series(bench, pure_leg_force(bench, robot, 1, [0.1, 100.0, 101.0, 100.9, 0.0]))
    found = leg_elongation(bench, robot, rows, 1, element)
    assert found[0] == pytest.approx(0.1 / (4 * k), rel=1e-3)
    assert (found[2] - found[1]) == pytest.approx(1.0 / k, rel=1e-2)
    assert (found[2] - found[3]) == pytest.approx(0.1 / (4 * k), rel=1e-2)
    assert found[1] == pytest.approx(94.0 / k, rel=2e-3)
    assert found[4] > 0  # a remanent deflection


def test_every_series_starts_relaxed(bench):
    robot = bench.robot("H1")
    load = pure_leg_force(bench, robot, 1, [20.0, 0.0])
    rows = bench.frame([POSE] * 4, **bench.wrenches(np.vstack([load, load])), series=[1, 1, 2, 2])
    found = bench.measure(robot, rows, el.FrictionHysteresis("all legs", 5.0))
    assert found[2:] == pytest.approx(found[:2], abs=1e-14)
    assert np.abs(found[1]).max() > 1e-7


def test_creep_depends_on_when_the_load_was_applied(bench):
    robot = bench.robot("H1")
    rows = series(bench, pure_leg_force(bench, robot, 4, [0.0, 100]), time_s=[0.0, 60])
    late = leg_elongation(bench, robot, rows, 4, el.Creep("leg 5", 0.1, 60.0, applied=1.0))
    half = leg_elongation(bench, robot, rows, 4, el.Creep("leg 5", 0.1, 60.0, applied=0.5))
    assert late[1] * robot.actuator_stiffness[4] / 100 == pytest.approx(1, abs=2e-4)
    assert half[1] * robot.actuator_stiffness[4] / 100 == pytest.approx(1 + 0.1 * (1 - np.exp(-0.5)), abs=2e-4)


def test_preloaded_contacts_are_linear_for_small_forces(bench):
    """Two contacts C F^(2/3) preloaded by P: stiffness 3 P^(1/3) / C for N << P."""
    robot = bench.robot("H1")
    element = el.LegNonlinearStiffness("leg 2", "hertz", contact_m_per_N23=1e-7, preload_N=1000.0)
    rows = series(bench, pure_leg_force(bench, robot, 1, [-20.0, 20.0]))
    found = leg_elongation(bench, robot, rows, 1, element)
    compliance = 1 / robot.actuator_stiffness[1] + 1e-7 / (3 * 10.0)
    assert found == pytest.approx([-20 * compliance, 20 * compliance], rel=1e-3)


def test_softening_leg_has_a_peak(bench):
    robot = bench.robot("H1")
    rows = series(bench, pure_leg_force(bench, robot, 1, 1e5))
    with pytest.raises(LaboratoryError, match=r"leg 2.*peak"):
        bench.measure(robot, rows, el.LegNonlinearStiffness("leg 2", cubic_per_m2=-1e9))


# instrument ---------------------------------------------------------------------------------------------


def test_outliers_spoil_single_rows(bench):
    robot = bench.robot("H1")
    rows = series(bench, [WRENCH] * 10)
    found = difference(bench, robot, rows, el.Outlier(rows=[3]))
    assert np.flatnonzero(np.abs(found).max(axis=1) > 1e-9).tolist() == [3]
    assert np.abs(found[3]) == pytest.approx([1e-5] * 3 + [4e-5] * 3)
    found = difference(bench, robot, rows, el.Outlier(fraction=0.2))
    assert np.count_nonzero(np.abs(found).max(axis=1) > 1e-9) == 2


# outside the library ------------------------------------------------------------------------------------


def test_taut_cable_stiffens_and_a_slack_one_does_not(bench):
    robot, model = bench.robot("H1"), bench.Linear(bench.robot("H1"), HOME)
    vertical: dict[str, Any] = {"base_m": [0, 0, 0], "platform_m": [0, 0, 0], "stiffness_N_per_m": 1e4}
    rows = one(bench, pose=HOME)
    assert np.abs(difference(bench, robot, rows, el.Cable(slack_m=0.31, **vertical))).max() < 1e-14
    pulled = difference(bench, robot, rows, el.Cable(slack_m=0.299, **vertical))[0]
    assert close(pulled, model.deflection([0, 0, -10, 0, 0, 0]), 2e-2)


def test_attraction_pulls_by_the_square_of_distance(bench):
    robot, model = bench.robot("H1"), bench.Linear(bench.robot("H1"), HOME)
    magnet = el.Attraction(magnet_m=[0.2, 0, 0.3], force_N=40.0, distance_m=0.1)
    found = difference(bench, robot, one(bench, pose=HOME), magnet)[0]
    assert close(found, model.deflection([10, 0, 0, 0, 0, 0]), 2e-3)


def test_stop_holds_the_platform(bench):
    robot = bench.robot("H1")
    down = [np.array([0, 0, -f, 0, 0, 0]) for f in (50.0, 150.0, 300.0)]
    rows = series(bench, down, HOME)
    free = bench.measure(robot, rows)[:, 2]
    stop = el.UnilateralStop([0, 0, 0], clearance_m=4e-6, stiffness_N_per_m=1e10)
    held = bench.measure(robot, rows, stop)[:, 2]
    assert held[0] == pytest.approx(free[0], rel=1e-9)
    assert held[1:] == pytest.approx([-4e-6, -4e-6], abs=5e-8)
    away = bench.measure(robot, rows, el.UnilateralStop([0, 0, 0], 4e-6, 1e10, centre_m=[1, 0, 0], radius_m=0.1))
    assert away[:, 2] == pytest.approx(free, rel=1e-9)


def test_loose_mount_slips_beyond_its_holding_force(bench):
    robot = bench.robot("H1")
    loads = [np.array([f, 0, -100, 0, 0, 0]) for f in (10.0, 30.0)]
    rows = bench.frame([HOME] * 2 + [POSE], **bench.wrenches([*loads, loads[1]]))
    mount = el.LooseMount(holding_N=20.0, slip_m=3e-6, radius_m=0.01)
    found = difference(bench, robot, rows, mount)
    assert found[1] - found[0] == pytest.approx([3e-6, 0, 0, 0, 0, 0], abs=6e-8)
    assert np.abs(found[[0, 2]]).max() < 2e-7  # the clamp's own elasticity


def test_distortion_scales_with_place(bench):
    robot = bench.robot("H1")
    true = bench.measure(robot, one(bench))[0]
    element = el.InstrumentDistortion([-0.5, 0, 0], quadratic_per_m=[0.01, 0, 0])
    shown = bench.measure(robot, one(bench), element)[0]
    assert shown[0] / true[0] == pytest.approx(1 + 2 * 0.01 * 0.52, rel=1e-6)
    assert shown[1:] == pytest.approx(true[1:], abs=1e-15)
