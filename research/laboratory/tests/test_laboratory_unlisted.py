"""Physics outside the library: it vanishes at size zero, agrees with known limits, and makes no energy."""

from __future__ import annotations

from math import log1p

import numpy as np
import pytest

pytest.importorskip("exudyn", reason="the virtual laboratory needs the engine exudyn")
from research.laboratory.elements import (
    BaseCompliance,
    Creep,
    FrictionHysteresis,
    LegBacklash,
    PayloadComOffset,
)
from research.laboratory.elements.forms import FORMS, DahlFriction, OtherCreep, OtherDrift, OtherSpring, SmearedBacklash
from research.laboratory.elements.unlisted import UNLISTED, instrument, leg_curves, leg_memories, mounts, surroundings
from research.laboratory.legs import Leg, LegConditions

POSES = np.array([[0.01, -0.01, 0.005, 0.05, -0.04, 0.1], [-0.015, 0.01, 0.0, -0.08, 0.06, -0.05]])
SOFT = Leg(0, 1e7)

NOTHING = [
    leg_curves.ScrewLength("leg 2", 0.0, 0.3),
    leg_curves.ScrewWear("leg 2", 0.0, 0.3, 0.01),
    leg_curves.WarmLeg("leg 2", 0.0, 20.0),
    leg_memories.PlaceFriction("leg 2", 0.0, 0.3, 0.01),
    leg_memories.BoucWen("leg 2", 0.0, 10.0),
    leg_memories.Seating("leg 2", 0.0),
    leg_memories.HoldingDroop("leg 2", 0.0, 10.0, 5.0),
    leg_curves.SaggingLeg("leg 2", 0.0),
    leg_memories.PlaceBacklash("leg 2", 0.0, 0.3, 0.01),
    leg_curves.EncoderDefect("leg 2", 0.0, 0.3, 0.01),
    leg_curves.LoadFeedForward("all legs", 0.0, (1.0, 0.0, 0.0)),
    leg_memories.SharedSupply(0.0, 100.0),
    leg_curves.LengthScale("leg 2", 0.0, 0.3),
    leg_curves.NeedleBearing("leg 2", 0.0, 0.1),
    leg_curves.WornSocket("leg 2", 0.0, 0.01, 0.1),
    mounts.OpeningBolt(0.0, 0.0),
    mounts.DishingPlate(0.0, 10.0),
    mounts.DraggingMount(0.0, 1.0),
    surroundings.Sloshing(0.0),
    surroundings.DroopingPayload(0.0, (0.0, 0.0, 1.0)),
    surroundings.Hose((0.5, 0.0, 0.3), (0.1, 0.0, 0.0), 0.6, 0.0),
    surroundings.Bellows((1.0, 0.0, 0.0), 0.0, 0.0),
    surroundings.Wind(0.0, (1.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
    surroundings.TautWire((0.5, 0.0, 0.3), (0.1, 0.0, 0.0), 0.0),
    mounts.RubberBase((0.0, 0.0, 0.0), 10.0),
    mounts.SinkingFloor(0.0, 0.0, 10.0),
    mounts.LiftingFoot((1.0, 0.0, 0.0), 0.0, 0.0),
    mounts.SwayingBuilding((1.0, 0.0, 0.0), 0.0, 100.0),
    leg_memories.BaseGradient(0.0, (1.0, 0.0, 0.0), np.ones((6, 3)).tolist()),
    instrument.GaugeCrossTalk(np.zeros((3, 3)).tolist()),
    instrument.InterpolationError((0.0, 0.0, 0.0), 1e-6),
    instrument.GaugeLostMotion(0.0, 0),
    instrument.Refraction(0.0, (1.0, 1.0, 0.0)),
    SmearedBacklash("leg 2", 0.0, 1.0),
    DahlFriction("leg 2", 0.0, 1e7),
    OtherCreep("leg 2", "power", 0.0, 10.0),
    OtherSpring("leg 2", "root", 0.0, 10.0),
    OtherDrift("leg 2", "saturating", 0.0, 100.0),
]


def rows_of(bench, poses=POSES):
    """Two series of three rows: unloaded, loaded, half."""
    levels = np.tile([0.0, 1.0, 0.5], len(poses))
    wrench = np.array([20.0, -10.0, -200.0, 5.0, 3.0, 2.0])
    rows = bench.frame(np.repeat(poses, 3, axis=0), **bench.wrenches(np.outer(levels, wrench)))
    rows["series"] = np.repeat(np.arange(len(poses)), 3)
    rows["time_s"] = np.arange(len(rows)) * 30.0
    rows["temperature_degC"] = 20.0 + 0.2 * np.arange(len(rows))
    return rows


def bipod_rows(bench, forces, **columns):
    """One series of a bipod at its zero pose; forces (fx, fy) row by row."""
    forces = np.atleast_2d(np.asarray(forces, dtype=float))
    rows = bench.frame(np.tile([0.0, 0.8], (len(forces), 1)), **bench.wrenches(forces), **columns)
    rows["series"] = 1
    return rows


def run(law, forces, times=None, **conditions):
    """Elongations of one leg's law along a path of forces."""
    found = []
    for step, force in enumerate([0.0, *forces]):
        at = LegConditions(float(times[step - 1]) if times is not None and step else 0.0, 20.0, 0.3, **conditions)
        if step == 0:
            law.start(at)
        else:
            found.append(law.elongation(force, at))
        law.accept(force, at)
    return np.array(found)


def test_the_table_of_vanishing_elements_holds_every_kind():
    assert {each.identifier for each in NOTHING} == set(UNLISTED) | set(FORMS)


@pytest.mark.parametrize("element", NOTHING, ids=lambda element: element.identifier)
def test_each_vanishes_at_size_zero(bench, element):
    robot, rows = bench.robot("H1"), rows_of(bench)
    assert bench.measure(robot, rows, element) == pytest.approx(bench.measure(robot, rows), abs=5e-12)


def test_a_law_of_length_is_the_base_model_with_another_compliance_at_every_pose(bench):
    robot, wrench = bench.robot("H1"), np.array([1.0, -2.0, -20.0, 0.3, 0.2, 0.1])
    element = leg_curves.ScrewLength("leg 3", 4.0, 0.3)
    for pose in POSES:
        linear = bench.Linear(robot, pose)
        compliance = 1 / robot.actuator_stiffness
        compliance[2] = element.curve(float(linear.q[2]), Leg(2, float(robot.actuator_stiffness[2])))
        found = bench.measure(robot, bench.frame(pose, **bench.wrenches(wrench)), element)[0]
        assert found == pytest.approx(linear.deflection(wrench, compliance), rel=1e-3, abs=1e-10)


def test_wear_is_local_and_its_curve_is_the_leg_compliance():
    wear = leg_curves.ScrewWear("leg 1", 0.5, 0.3, 0.01)
    assert wear.curve(0.3, SOFT) == pytest.approx(1.5e-7)
    assert wear.curve(0.4, SOFT) == pytest.approx(1e-7)
    assert wear.law(SOFT).elongation(100.0, LegConditions(0, 0, 0.3)) == pytest.approx(0.5e-5)


def test_friction_where_it_is_tight_is_coulomb_friction_and_none_elsewhere():
    path = [30.0, 60.0, 20.0, -40.0, 0.0]
    tight, coulomb = leg_memories.PlaceFriction("leg 1", 15.0, 0.3, 0.01).law(SOFT), FrictionHysteresis("leg 1", 15.0)
    assert run(tight, path) == pytest.approx(run(coulomb.law(SOFT), path))
    assert run(leg_memories.PlaceFriction("leg 1", 15.0, 0.5, 0.01).law(SOFT), path) == pytest.approx(0.0, abs=1e-18)


@pytest.mark.parametrize(
    "element", [leg_memories.BoucWen("leg 1", 0.8, 30.0), DahlFriction("leg 1", 20.0, 4e7)], ids=["bouc_wen", "dahl"]
)
def test_a_cycle_of_load_loses_energy(element):
    loop = 80.0 * np.sin(np.linspace(0, 4 * np.pi, 401))
    stretched = run(element.law(SOFT), loop) + loop / SOFT.stiffness
    last = slice(200, 401)  # the first cycle begins relaxed; the second one closes
    assert stretched[400] == pytest.approx(stretched[200], rel=1e-3)
    assert np.trapezoid(loop[last], stretched[last]) > 0


def test_stiff_bristles_are_coulomb_friction():
    path = [30.0, 60.0, 20.0, -40.0, 0.0]
    stiff = DahlFriction("leg 1", 15.0, 1e13).law(SOFT)
    assert run(stiff, path) == pytest.approx(run(FrictionHysteresis("leg 1", 15.0).law(SOFT), path), abs=1e-11)


def test_a_seat_keeps_its_set():
    found = run(leg_memories.Seating("leg 1", 0.1).law(SOFT), [50.0, 100.0, 0.0, -40.0])
    assert found * SOFT.stiffness == pytest.approx([5.0, 10.0, 10.0, 6.0])


def test_a_drive_droops_only_after_its_delay():
    found = run(leg_memories.HoldingDroop("leg 1", 0.3, 100.0, 2.0).law(SOFT), [50.0, 50.0], times=[10.0, 200.0])
    assert found * SOFT.stiffness == pytest.approx([0.0, 15.0], abs=1e-9)


def test_play_where_it_is_worn_is_play(bench):
    robot = bench.robot("bipod")
    rows = bipod_rows(bench, [[50.0, 0.0], [-50.0, 20.0]])
    length = float(bench.Linear(robot, [0.0, 0.8]).q[0])
    worn = bench.measure(robot, rows, leg_memories.PlaceBacklash("leg 1", 2e-6, length, 0.01, seat_N=1e-3))
    assert worn == pytest.approx(bench.measure(robot, rows, LegBacklash("leg 1", 2e-6)), abs=1e-12)
    elsewhere = bench.measure(robot, rows, leg_memories.PlaceBacklash("leg 1", 2e-6, length + 0.2, 0.01))
    assert elsewhere == pytest.approx(bench.measure(robot, rows), abs=1e-12)


def test_an_encoder_defect_offsets_all_rows_at_its_place(bench):
    robot, rows = bench.robot("bipod"), bipod_rows(bench, [[0.0, 0.0], [0.0, -20.0]])
    linear = bench.Linear(robot, [0.0, 0.8])
    defect = leg_curves.EncoderDefect("leg 1", 3e-6, float(linear.q[0]), 0.01)
    offset = bench.measure(robot, rows, defect) - bench.measure(robot, rows)
    assert offset == pytest.approx(np.tile(linear.J[:, 0] * 3e-6, (2, 1)), abs=1e-10)


def test_feed_forward_errs_in_opposite_directions_at_opposite_places():
    law = leg_curves.LoadFeedForward("leg 1", 5.0, (1.0, 0.0, 0.0)).law(SOFT)
    there, opposite = (
        law.elongation(100.0, LegConditions(0, 0, 0.3, travel=np.array([x, 0.3, 0.0]))) for x in (0.02, -0.02)
    )
    assert there == pytest.approx(-0.1 * 1e-5)
    assert opposite == pytest.approx(-there)


def test_a_shared_supply_sags_with_the_sum_of_all_forces(bench):
    robot, rows = bench.robot("bipod"), bipod_rows(bench, [[0.0, -100.0]])
    linear = bench.Linear(robot, [0.0, 0.8])
    total = float(np.abs(linear.tau([0.0, -100.0])).sum())
    expected = linear.deflection([0.0, -100.0]) * (1 + 0.2 * total / 50.0)
    assert bench.measure(robot, rows, leg_memories.SharedSupply(0.2, 50.0))[0] == pytest.approx(expected, rel=1e-4)


def test_a_lying_leg_is_softer_than_an_upright_one():
    law = leg_curves.SaggingLeg("leg 1", 0.4).law(SOFT)
    upright, lying = (
        law.elongation(100.0, LegConditions(0, 0, 0.3, direction=np.array(u))) for u in ([0, 0, 1.0], [1.0, 0, 0])
    )
    assert (upright, lying) == pytest.approx((0.0, 0.4e-5))


def test_joints_are_softer_at_the_angles_their_curves_say():
    home = np.array([0.0, np.sin(0.5), np.cos(0.5)])
    swivelled = np.array([0.0, np.sin(0.6), np.cos(0.6)])
    at = LegConditions(0, 0, 0.3, direction=swivelled, home_direction=home)
    worn, needles = (
        leg_curves.WornSocket("leg 1", 0.5, 0.04, 0.1),
        leg_curves.NeedleBearing("leg 1", 0.5, 0.2, fork_rad=np.pi / 2),
    )
    assert worn.law(SOFT).elongation(10.0, at) == pytest.approx(10.0 * (worn.curve(0.1, SOFT) - 1e-7))
    assert needles.law(SOFT).elongation(10.0, at) == pytest.approx(10.0 * (needles.curve(0.1, SOFT) - 1e-7), abs=1e-15)
    assert worn.curve(0.03, SOFT) == 1e-7
    assert needles.curve(0.0, SOFT) == pytest.approx(1.5e-7)
    assert needles.curve(0.1, SOFT) == pytest.approx(1.0e-7)


def test_a_wrong_lead_moves_the_platform_even_without_load(bench):
    from research.laboratory import Laboratory  # noqa: PLC0415 - the engine may be missing

    robot, rows = bench.robot("bipod"), bipod_rows(bench, [[0.0, 0.0]])
    linear = bench.Linear(robot, [0.0, 0.8])
    moved = Laboratory(robot, elements=[leg_curves.LengthScale("leg 1", 1e-3, float(linear.q[0]) - 0.01)]).attained(
        rows
    )
    assert moved.to_numpy()[0] - [0.0, 0.8] == pytest.approx(linear.J[:, 0] * 1e-5, abs=1e-9)


def test_a_bolt_holds_up_to_its_moment_and_opens_beyond(bench):
    robot = bench.robot("H1")
    wrench = np.zeros((3, 6))
    wrench[:, 4] = [10.0, -20.0, 40.0]
    rows = bench.frame(np.zeros((3, 6)), **bench.wrenches(wrench))
    change = bench.measure(robot, rows, mounts.OpeningBolt(20.0, 1e-6)) - bench.measure(robot, rows)
    assert change[:2] == pytest.approx(np.zeros((2, 6)), abs=1e-11)
    assert change[2] == pytest.approx([0, 0, 0, 0, 20e-6, 0], abs=1e-9)


@pytest.mark.parametrize(
    ("element", "axis", "loads", "expected", "close"),
    [
        (mounts.DishingPlate(1e-7, 100.0), 2, [-1.0, -300.0], [-1e-7 / 1.01, -300e-7 / 4.0], {"rel": 1e-3}),
        (mounts.DraggingMount(1e-7, 20.0), 0, [10.0, 60.0, 50.0, 0.0], [0, 40e-7, 40e-7, 20e-7], {"abs": 1e-10}),
        (mounts.SinkingFloor(1e-8, 0.0, 10.0), 2, [0.0, -100.0, -100.0], [0, -1e-6 * log1p(6.0), -1e-6 * log1p(60.0)],
         {"abs": 1e-10}),
        (mounts.LiftingFoot((1.0, 0.0, 0.0), 20.0, 1e-6), 3, [10.0, 50.0, -50.0], [0.0, 30e-6, 0.0], {"abs": 1e-9}),
    ],
    ids=["a plate yields less later", "a mount stays where it is dragged", "a floor sinks", "a foot lifts on one side"],
)  # fmt: skip
def test_a_mount_or_a_base_yields_by_its_law_along_the_load(bench, element, axis, loads, expected, close):
    robot, wrench = bench.robot("H1"), np.zeros((len(loads), 6))
    wrench[:, axis] = loads
    times = [0.0, 60.0, 600.0, 700.0][: len(loads)]
    rows = bench.frame(np.zeros((len(loads), 6)), **bench.wrenches(wrench), series=1, time_s=times)
    change = bench.measure(robot, rows, element) - bench.measure(robot, rows)
    assert change[:, axis] == pytest.approx(expected, **close)


def test_a_load_that_runs_downhill_is_an_offset_of_its_centre(bench):
    robot, tilt = bench.robot("H1"), 0.1
    rows = bench.frame(np.array([[0, 0, 0, 0, tilt, 0], [0, 0, 0, 0, 0, 0.0]]), mass_kg=20.0)
    for name in ("com_x_m", "com_y_m", "com_z_m"):
        rows[name] = 0.0
    found = bench.measure(robot, rows, surroundings.Sloshing(0.05))
    level = bench.measure(robot, rows)
    downhill = PayloadComOffset(com_dx_m=0.05 * np.sin(tilt))  # Ry(tilt) turns +x of the platform down
    assert found[0] == pytest.approx(bench.measure(robot, rows, downhill)[0], abs=1e-11)
    assert found[1] == pytest.approx(level[1], abs=1e-12)


def test_a_drooping_payload_makes_a_moment_that_is_quadratic_in_its_weight(bench):
    robot = bench.robot("H1")
    rows = bench.frame(np.tile([0, 0, 0, 0.1, 0, 0.0], (2, 1)), mass_kg=[10.0, 20.0])
    for name in ("com_x_m", "com_y_m", "com_z_m"):
        rows[name] = 0.0
    change = bench.measure(robot, rows, surroundings.DroopingPayload(1e-4, (0.0, 1.0, 0.0))) - bench.measure(
        robot, rows
    )
    assert change[1, 3] == pytest.approx(4 * change[0, 3], rel=1e-3)


@pytest.mark.parametrize("kind", ["bellows", "wind"])
def test_a_force_from_outside_is_a_wrench_that_comes_with_the_load(bench, kind):
    robot, wrench = bench.robot("H1"), np.zeros((2, 6))
    wrench[1, 2] = -100.0
    rows = bench.frame(np.zeros((2, 6)), **bench.wrenches(wrench), series=1)
    element = (
        surroundings.Bellows((1.0, 0.0, 0.0), 7.0, 50.0)
        if kind == "bellows"
        else surroundings.Wind(7.0, (1.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    )
    more = wrench.copy()
    more[1, 0] = 7.0
    expected = bench.measure(robot, bench.frame(np.zeros((2, 6)), **bench.wrenches(more), series=1))
    assert bench.measure(robot, rows, element) == pytest.approx(expected, rel=1e-4, abs=1e-10)


def test_a_hose_pulls_the_payload_towards_its_post_and_down(bench):
    robot = bench.robot("bipod")
    rows = bipod_rows(bench, [[0.0, -50.0]])
    hose = surroundings.Hose((1.0, 0.8, 0.0), (0.0, 0.0, 0.0), 1.05, 10.0, down=(0.0, -1.0, 0.0))
    change = (bench.measure(robot, rows, hose) - bench.measure(robot, rows))[0]
    sag = np.sqrt(3 * 1.0 * 0.05 / 8)
    expected = bench.Linear(robot, [0.0, 0.8]).deflection([10.0 / (8 * sag), -10.0 * 1.05 / 2])
    assert change == pytest.approx(expected, rel=1e-3)


def test_a_wire_adds_its_stiffness_to_that_of_the_legs(bench):
    robot, force = bench.robot("bipod"), np.array([30.0, -50.0])
    rows = bipod_rows(bench, [force])
    wire = surroundings.TautWire((1.0, 0.8, 0.0), (0.0, 0.0, 0.0), 4e6)
    linear = bench.Linear(robot, [0.0, 0.8])
    stiffness = linear.J_inverse.T @ np.diag(robot.actuator_stiffness) @ linear.J_inverse + np.diag([4e6, 0.0])
    assert bench.measure(robot, rows, wire)[0] == pytest.approx(np.linalg.solve(stiffness, force), rel=1e-4)


def test_rubber_that_does_not_stiffen_is_a_compliant_base(bench):
    robot, rows = bench.robot("H1"), rows_of(bench)
    rubber = mounts.RubberBase((1e-7, 2e-7, 3e-8), 1e12, 1e-6, 1e12)
    linear = BaseCompliance([1e7, 5e6, 1 / 3e-8, 1e6, 1e6, 1e6])
    assert bench.measure(robot, rows, rubber) == pytest.approx(bench.measure(robot, rows, linear), rel=2e-3, abs=2e-8)


def test_a_building_sways_whatever_the_load_is(bench):
    robot, rows = bench.robot("H1"), rows_of(bench)
    sway = mounts.SwayingBuilding((1.0, 0.0, 0.0), 1e-5, 400.0)
    change = bench.measure(robot, rows, sway) - bench.measure(robot, rows)
    first = np.repeat(rows["time_s"].to_numpy()[[0, 3]], 3)
    wave = 1e-5 * (np.sin(2 * np.pi * rows["time_s"] / 400.0) - np.sin(2 * np.pi * first / 400.0))
    turned = np.array([bench.euler_rates(pose[3:], robot.orientation) for pose in np.repeat(POSES, 3, axis=0)])
    expected = np.linalg.solve(turned, np.outer(wave, [1.0, 0.0, 0.0])[:, :, None])[:, :, 0]
    assert change[:, 3:] == pytest.approx(expected, abs=2e-8)


def test_a_growing_base_carries_the_platform_along(bench):
    robot = bench.robot("bipod")
    rows = bipod_rows(bench, [[0.0, 0.0], [0.0, 0.0]], temperature_degC=[20.0, 21.0])
    gradient = leg_memories.BaseGradient(1e-5, (1.0, 0.0, 0.0), robot.base_joints.tolist())
    linear = bench.Linear(robot, [0.0, 0.8])
    moved = 1e-5 * robot.base_joints[:, :1] * [1.0, 0.0]
    expected = linear.J @ np.sum(linear.u * moved, axis=1)
    assert bench.measure(robot, rows, gradient)[1] == pytest.approx(expected, abs=1e-10)


def test_instruments_misread_as_their_laws_say(bench):
    robot, rows = bench.robot("H1"), rows_of(bench)
    plain = bench.measure(robot, rows)
    talk = np.zeros((3, 3))
    talk[0, 2] = 1e3
    crossed = bench.measure(robot, rows, instrument.GaugeCrossTalk(talk.tolist()))
    assert crossed[:, 0] == pytest.approx(plain[:, 0] + 1e3 * plain[:, 2] ** 2)
    assert crossed[:, 1:] == pytest.approx(plain[:, 1:])
    waved = bench.measure(robot, rows, instrument.InterpolationError((0.0, 1e-7, 0.0), 1e-6))
    assert waved[:, 1] == pytest.approx(plain[:, 1] + 1e-7 * np.sin(2 * np.pi * plain[:, 1] / 1e-6))
    bent = bench.measure(robot, rows, instrument.Refraction(1e-6, (2.0, 0.0, 0.0)))
    square = (rows["x_m"] - 2.0) ** 2 + rows["y_m"] ** 2
    assert bent[:, 2] == pytest.approx(plain[:, 2] + 1e-6 * square * 0.2 * np.tile([0, 1, 2], 2))


def test_a_gauge_with_lost_motion_lags_by_half_its_play():
    deflections, rows = np.array([[0.5], [3.0], [2.5], [0.0]]) * 1e-6, pd_series(4)
    shown = instrument.GaugeLostMotion(2e-6, 0).misread(deflections, rows)
    assert shown[:, 0] == pytest.approx([0.0, 2e-6, 2e-6, 1e-6])


def pd_series(count):
    import pandas as pd  # noqa: PLC0415 - for one test

    return pd.DataFrame({"series": [1] * count, "sequence": range(count)})


def test_a_stretched_exponential_of_shape_one_is_a_standard_solid():
    path, times = [50.0, 50.0, 80.0, 0.0], [20.0, 60.0, 100.0, 180.0]
    solid = run(Creep("leg 1", 0.4, 50.0).law(SOFT), path, times)
    assert run(OtherCreep("leg 1", "stretched", 0.4, 50.0, 1.0).law(SOFT), path, times) == pytest.approx(solid)


@pytest.mark.parametrize("kind", ["stretched", "logarithmic", "power", "two_maxwell"])
def test_every_creep_grows_from_nothing(kind):
    creep = OtherCreep("leg 1", kind, 0.4, 50.0, 0.4)
    grown = [creep.grown(time) for time in (0.0, 10.0, 100.0, 1000.0)]
    assert grown[0] == 0.0
    assert all(np.diff(grown) > 0)


def test_other_springs_have_the_limits_of_the_known_ones():
    loss = OtherSpring("leg 1", "preload_loss", 0.5, 40.0)
    assert [loss.curve(f, SOFT) * SOFT.stiffness for f in (30.0, 60.0, -60.0)] == pytest.approx([0.0, 10.0, -10.0])
    bilinear = OtherSpring("leg 1", "smeared_bilinear", 0.5, 1e-3)
    slopes = [bilinear.curve(f, SOFT) * SOFT.stiffness / f for f in (50.0, -50.0)]
    assert slopes == pytest.approx([0.5, 0.0], abs=1e-4)
    for shape in ("exponential", "root"):
        spring = OtherSpring("leg 1", shape, 0.5, 40.0)
        assert spring.curve(30.0, SOFT) == -spring.curve(-30.0, SOFT) > 0
        assert spring.curve(60.0, SOFT) < 2 * spring.curve(30.0, SOFT)  # hardening


def test_play_smeared_over_little_force_is_play():
    assert SmearedBacklash("leg 1", 2e-6, 1e-3).curve(5.0, SOFT) == pytest.approx(1e-6)
    assert SmearedBacklash("leg 1", 2e-6, 10.0).curve(5.0, SOFT) < 1e-6


def test_a_drive_that_warms_up_grows_less_and_less():
    drift = OtherDrift("leg 1", "saturating", 5e-6, 1000.0)
    at = [drift.stretch(0.0, SOFT, LegConditions(t, 20.0, 0.3)) for t in (0.0, 1000.0, 2000.0)]
    assert at[0] == 0.0
    assert at[1] - at[0] > at[2] - at[1] > 0


def test_warmth_softens():
    law = leg_curves.WarmLeg("leg 1", 0.1, 20.0).law(SOFT)
    assert law.elongation(100.0, LegConditions(0, 22.0, 0.3)) == pytest.approx(0.2e-5)
