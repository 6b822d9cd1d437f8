"""Every element in a limit with a known answer, from the linear model of theory.md 2.3."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

pytest.importorskip("exudyn", reason="the virtual laboratory needs the engine exudyn")
from virtual_laboratory import Laboratory, LaboratoryError
from virtual_laboratory import elements as el

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


def test_payload_com_offset_is_another_centre_of_mass(bench):
    robot = bench.robot("H1")
    wrong = bench.measure(robot, payload(bench), el.PayloadComOffset(0.01, -0.005, 0.02))
    assert wrong == pytest.approx(bench.measure(robot, payload(bench, com=(0.04, 0.015, 0.17))), abs=1e-15)


def test_payload_com_offset_moves_the_point_of_a_wrench(bench):
    robot, model = bench.robot("H1"), bench.Linear(bench.robot("H1"), POSE)
    offset = np.array([0.01, -0.005, 0.02])
    moment = np.cross(bench.rotation(np.array(POSE[3:]), "fixed-xyz") @ offset, WRENCH[:3])
    expected = model.deflection(np.concatenate([np.zeros(3), moment]))
    assert close(difference(bench, robot, one(bench), el.PayloadComOffset(*offset))[0], expected, 3e-3)


def test_payload_mass_error_scales(bench):
    robot = bench.robot("H1")
    wrong = bench.measure(robot, payload(bench), el.PayloadMassError(0.05))
    assert wrong == pytest.approx(bench.measure(robot, payload(bench, mass=21.0)), abs=1e-15)


def test_load_direction_tilt_turns_gravity(bench):
    robot = bench.robot("H1")
    wrong = bench.measure(robot, payload(bench), el.LoadDirectionTilt(tilt_x_rad=0.01))
    g = 9.80665 * np.array([0, np.sin(0.01), -np.cos(0.01)])
    rows = payload(bench)
    rows[["gx_m_s2", "gy_m_s2", "gz_m_s2"]] = g
    assert wrong == pytest.approx(bench.measure(robot, rows), abs=1e-15)


# structure ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("bushing", [el.PlatformCompliance, el.BaseCompliance])
def test_bushing_is_in_series(bench, bushing):
    """At the home pose, centred on the origin of P, a bushing adds w / k to the deflection, below as above the legs."""
    robot = bench.robot("H1")
    stiffness = np.array([4e7, 5e7, 9e7, 1e6, 2e6, 3e6])
    at = robot.home if bushing is el.BaseCompliance else np.zeros(3)
    found = difference(bench, robot, one(bench, pose=HOME), bushing(stiffness, at))[0]
    assert close(found, WRENCH / stiffness)


def test_base_compliance_at_the_ground_sees_the_moment_of_the_force(bench):
    robot = bench.robot("H1")
    stiffness = np.array([4e7, 5e7, 9e7, 1e6, 2e6, 3e6])
    force, moment, home = WRENCH[:3], WRENCH[3:], robot.home
    turn = (moment + np.cross(home, force)) / stiffness[3:]
    expected = np.concatenate([force / stiffness[:3] + np.cross(turn, home), turn])
    assert close(difference(bench, robot, one(bench, pose=HOME), el.BaseCompliance(stiffness))[0], expected)


def test_compliant_base_of_a_bipod(bench):
    robot = bench.robot("bipod")
    wrench = np.array([50.0, -300.0])
    turn = (0.1 * wrench[1] - 0.6 * wrench[0]) / 2e6
    expected = wrench / [3e7, 4e7] + turn * np.array([-0.6, 0.1])
    rows = bench.frame([0.1, 0.6], **bench.wrenches(wrench))
    found = difference(bench, robot, rows, el.BaseCompliance([3e7, 4e7, 1e7, 1e6, 1e6, 2e6]))[0]
    assert close(found, expected)


def test_leg_coupling_deflects_the_neighbour(bench):
    """Legs 1 and 2 on one mount: leg 2 changes its length by u2 . C u1 for a force of 1 N in leg 1."""
    robot, model = bench.robot("H1"), bench.Linear(bench.robot("H1"), POSE)
    stiffness = np.array([3e7, 4e7, 5e7, 1e6, 1e6, 1e6])
    joints = robot.base_joints
    middle = joints[:2].mean(axis=0)
    tau = model.tau(WRENCH)
    pairs = zip(model.u[:2], joints[:2], strict=True)
    rows = np.array([np.concatenate([u, np.cross(j - middle, u)]) for u, j in pairs])
    lengths = np.zeros(6)
    lengths[:2] = rows @ ((rows.T @ tau[:2]) / stiffness)
    found = difference(bench, robot, one(bench), el.LegCoupling([1, 2], stiffness))[0]
    assert close(found, model.J_check @ lengths)


# joints -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("end", ["base", "platform"])
def test_passive_joint_compliance_adds_to_its_leg(bench, end):
    """A mount of compliance C adds u . C u to the compliance of its leg."""
    robot, model = bench.robot("H1"), bench.Linear(bench.robot("H1"), POSE)
    stiffness = np.array([2e7, 1e8, 1e8])
    joint = (robot.base_joints if end == "base" else robot.platform_joints)[2]
    c, s = joint[:2] / np.linalg.norm(joint[:2])
    axes = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    if end == "platform":
        axes = bench.rotation(np.array(POSE[3:]), "fixed-xyz") @ axes
    compliance = np.zeros(6)
    compliance[2] = model.u[2] @ axes @ np.diag(1 / stiffness) @ axes.T @ model.u[2]
    found = difference(bench, robot, one(bench), el.PassiveJointCompliance("leg 3", stiffness, end))[0]
    assert close(found, model.deflection(WRENCH, compliance))


def test_passive_joint_stiffness_adds_to_the_platform_stiffness(bench):
    """Energy of the flexures for a platform twist: bending at both ends, and half the stiffness in torsion."""
    robot, model = bench.robot("H1"), bench.Linear(bench.robot("H1"), HOME)
    kappa = 2e4
    stiffness = model.J_inverse.T @ np.diag(robot.actuator_stiffness) @ model.J_inverse
    for u, b, q in zip(model.u, model.b, model.q, strict=True):
        across = np.eye(3) - np.outer(u, u)
        cross_u = np.array([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]])
        cross_b = np.array([[0, -b[2], b[1]], [b[2], 0, -b[0]], [-b[1], b[0], 0]])
        strut = cross_u @ np.hstack([np.eye(3), -cross_b]) / q  # rotation of the leg across its axis
        platform = np.hstack([np.zeros((3, 3)), np.eye(3)])
        relative = across @ platform - strut
        torsion = u[None, :] @ platform
        stiffness += kappa * (strut.T @ strut + relative.T @ relative) + kappa / 2 * torsion.T @ torsion
    found = bench.measure(robot, one(bench, pose=HOME), el.PassiveJointStiffness(kappa))[0]
    assert close(found, np.linalg.solve(stiffness, WRENCH))
    assert not close(found, model.deflection(WRENCH), 0.05)


def test_passive_joint_stiffness_away_from_home(bench):
    """The flexures are free of moment at home; elsewhere they shift the unloaded pose but hardly the stiffness."""
    robot = bench.robot("H1")
    soft = bench.measure(robot, one(bench), el.PassiveJointStiffness(1e-3))[0]
    assert close(soft, bench.measure(robot, one(bench))[0], 1e-6)
    rows = one(bench, NONE)
    moved = Laboratory(robot, elements=[el.PassiveJointStiffness(100.0)]).attained(rows).to_numpy()[0] - POSE
    assert 1e-7 < np.abs(moved[:3]).max() < 1e-4


@pytest.mark.parametrize("end", ["base", "platform"])
def test_joint_position_error_moves_the_unloaded_platform(bench, end):
    """theory.md 9.I: dX = J-check (u . da) for a base joint and -J-check (u . R db) for a platform joint."""
    robot, model = bench.robot("H1"), bench.Linear(bench.robot("H1"), POSE)
    error = np.array([1e-5, -2e-5, 3e-5])
    shift = error if end == "base" else -bench.rotation(np.array(POSE[3:]), "fixed-xyz") @ error
    lengths = np.zeros(6)
    lengths[3] = model.u[3] @ shift
    wrong = el.JointPositionError("leg 4", end, *error)
    moved = Laboratory(robot, elements=[wrong]).attained(one(bench, NONE)).to_numpy()[0] - POSE
    assert close(moved, model.J_check @ lengths, 2e-3)


# legs ---------------------------------------------------------------------------------------------------


def leg_elongation(bench, robot, rows, leg, *elements):
    """Elongation of a leg in each row, from the deflections: row `leg` of the inverse modified Jacobian."""
    model = bench.Linear(robot, POSE)
    return bench.measure(robot, rows, *elements) @ model.J_check_inverse[leg]


def pure_leg_force(bench, robot, leg, force):
    """Wrenches under which only one leg carries: F = J^-T tau."""
    return np.outer(np.atleast_1d(force), bench.Linear(robot, POSE).J_inverse[leg])


def test_backlash_jumps_by_its_gap(bench):
    robot, model = bench.robot("H1"), bench.Linear(bench.robot("H1"), POSE)
    force = pure_leg_force(bench, robot, 2, [1.0, -1.0])
    rows = bench.frame([POSE] * 2, **bench.wrenches(force))
    gap = el.LegBacklash("leg 3", 1.2e-6)
    change = difference(bench, robot, rows, gap)
    assert close(change[0] - change[1], 1.2e-6 * model.J_check[:, 2])
    assert close(change[0], 0.6e-6 * model.J_check[:, 2])
    short = difference(bench, robot, rows, el.LegBacklash("leg 3", 1.2e-6, rest="short"))
    assert close(short[0], 1.2e-6 * model.J_check[:, 2])
    assert np.abs(short[1]).max() < 1e-11


def test_leg_floats_within_its_play(bench):
    """With flexures the platform has other ways to carry; a leg that does not reach the end of its gap is free."""
    robot = bench.robot("H1")
    stiff = el.PassiveJointStiffness(2e5)
    rows = one(bench, WRENCH, HOME)
    states = Laboratory(robot, elements=[stiff, el.LegBacklash("leg 3", 1e-3)]).states(rows)
    assert abs(states.leg_forces[0, 2]) < 1e-3
    assert np.abs(states.leg_forces[0, [0, 1, 3, 4, 5]]).min() > 0.1


def test_rigid_friction_sticks_then_lags(bench):
    robot = bench.robot("H1")
    forces = np.array([0.0, 4, 10, 4, -10, 0])
    rows = series(bench, pure_leg_force(bench, robot, 1, forces))
    found = leg_elongation(bench, robot, rows, 1, el.FrictionHysteresis("leg 2", 5.0)) * robot.actuator_stiffness[1]
    assert found == pytest.approx([0, 0, 5, 5, -5, -5], abs=2e-3)


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


def test_creep_grows_to_its_ratio(bench):
    robot = bench.robot("H1")
    load = pure_leg_force(bench, robot, 4, [0.0, 100, 100, 100, 0])
    rows = series(bench, load, time_s=[0.0, 0, 60, 6000, 6060])
    found = leg_elongation(bench, robot, rows, 4, el.Creep("leg 5", 0.1, 60.0)) * robot.actuator_stiffness[4] / 100
    assert found == pytest.approx([0, 1, 1 + 0.1 * (1 - np.exp(-1)), 1.1, 0.1 * np.exp(-1)], abs=2e-4)


def test_creep_depends_on_when_the_load_was_applied(bench):
    robot = bench.robot("H1")
    rows = series(bench, pure_leg_force(bench, robot, 4, [0.0, 100]), time_s=[0.0, 60])
    late = leg_elongation(bench, robot, rows, 4, el.Creep("leg 5", 0.1, 60.0, applied=1.0))
    half = leg_elongation(bench, robot, rows, 4, el.Creep("leg 5", 0.1, 60.0, applied=0.5))
    assert late[1] * robot.actuator_stiffness[4] / 100 == pytest.approx(1, abs=2e-4)
    assert half[1] * robot.actuator_stiffness[4] / 100 == pytest.approx(1 + 0.1 * (1 - np.exp(-0.5)), abs=2e-4)


def test_thermal_drift_is_a_strain(bench):
    robot, model = bench.robot("H1"), bench.Linear(bench.robot("H1"), POSE)
    rows = series(bench, [NONE, NONE, NONE], temperature_degC=[20.0, 20.5, 19.0], time_s=[0.0, 100, 200])
    found = bench.measure(robot, rows, el.ThermalDrift("leg 1", alpha_per_K=12e-6))
    assert np.abs(found[0]).max() < 1e-13
    assert close(found[1], model.J_check[:, 0] * 12e-6 * 0.5 * model.q[0])
    assert close(found[2], -model.J_check[:, 0] * 12e-6 * model.q[0])
    rows["leg1_degC"] = 20.0
    assert np.abs(bench.measure(robot, rows, el.ThermalDrift("leg 1", alpha_per_K=12e-6))).max() < 1e-13
    drift = bench.measure(robot, rows, el.ThermalDrift("leg 1", rate_per_s=1e-8))
    assert close(drift[2], model.J_check[:, 0] * 2e-6 * model.q[0])


def test_encoder_error_offsets_all_rows_of_a_series(bench):
    robot, model = bench.robot("H1"), bench.Linear(bench.robot("H1"), POSE)
    rows = series(bench, [NONE, WRENCH])
    found = difference(bench, robot, rows, el.EncoderPeriodicError("leg 6", 2e-6, 1e-3, 0.4))
    offset = 2e-6 * np.sin(2 * np.pi * model.q[5] / 1e-3 + 0.4) * model.J_check[:, 5]
    assert close(found[0], offset)
    assert close(found[1], offset, 2e-3)


def hertz(force, k):
    return force / k + 1e-7 * np.sign(force) * np.abs(force) ** (2 / 3)


def bilinear(force, k):
    return force / k * np.where(force < 0, 1.25, 1.0)


@pytest.mark.parametrize(
    ("parameters", "elongation"),
    [
        ({"law": "hertz", "contact_m_per_N23": 1e-7}, hertz),
        ({"law": "bilinear", "relative_change": -0.2}, bilinear),
    ],
)
def test_nonlinear_leg_follows_its_law(bench, parameters, elongation):
    robot = bench.robot("H1")
    forces = np.array([-200.0, -20, 20, 200])
    rows = series(bench, pure_leg_force(bench, robot, 1, forces))
    found = leg_elongation(bench, robot, rows, 1, el.LegNonlinearStiffness("leg 2", **parameters))
    assert found == pytest.approx(elongation(forces, robot.actuator_stiffness[1]), rel=1e-3)


@pytest.mark.parametrize("coefficient", [1e9, -1e8])
def test_cubic_leg_hardens_or_softens(bench, coefficient):
    robot = bench.robot("H1")
    forces = np.array([-150.0, 20, 150])
    rows = series(bench, pure_leg_force(bench, robot, 1, forces))
    d = leg_elongation(bench, robot, rows, 1, el.LegNonlinearStiffness("leg 2", cubic_per_m2=coefficient))
    assert robot.actuator_stiffness[1] * d * (1 + coefficient * d**2) == pytest.approx(forces, rel=1e-3)


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


def test_instrument_misalignment_turns_the_deflection(bench):
    robot = bench.robot("H1")
    true = bench.measure(robot, one(bench, pose=HOME))[0]
    shown = bench.measure(robot, one(bench, pose=HOME), el.InstrumentMisalignment(0.0, 0.0, 0.1))[0]
    turn = bench.rotation(np.array([0, 0, 0.1]), "fixed-xyz").T
    assert close(shown, np.concatenate([turn @ true[:3], turn @ true[3:]]), 1e-4)


def test_instrument_scale_scales_positions(bench):
    robot = bench.robot("H1")
    true = bench.measure(robot, one(bench))[0]
    shown = bench.measure(robot, one(bench), el.InstrumentScale(0.01, -0.02, 0.03))[0]
    assert shown / true == pytest.approx([1.01, 0.98, 1.03, 1, 1, 1], abs=1e-9)


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
