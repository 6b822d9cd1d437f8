"""The second source: its engines against closed formulas; what it conceals is what it claims."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

pytest.importorskip("mujoco", reason="the second source needs the extra second-source")
pytest.importorskip("openseespy", reason="the second source needs the extra second-source")
pytest.importorskip("Pynite", reason="the second source needs the extra second-source")
from research.benchmarks.concealed.arms import base_deflections
from research.benchmarks.concealed.campaigns import JOINTS, POSE, WRENCH, base_matrices
from research.benchmarks.concealed.hexapods import draw_hexapod, posture
from research.benchmarks.concealed.second_source import arms, frames, leg_kinds, pynite_frames, structure_kinds

HEXAPOD = draw_hexapod(np.random.default_rng(5))
LOAD = np.array([60.0, -40.0, -220.0, 6.0, -4.0, 3.0])


def rows(*wrenches: np.ndarray, times: list[float] | None = None) -> pd.DataFrame:
    found = pd.DataFrame(np.array(wrenches), columns=list(WRENCH)).assign(series=1)
    found[list(POSE)] = [0.01, -0.01, 0.005, 0.04, -0.05, 0.06]
    return found if times is None else found.assign(time_s=times)


def along(leg: int, force: float) -> np.ndarray:
    """The wrench that loads one leg alone, pulling it longer by a force (N)."""
    place = posture(HEXAPOD, rows(LOAD)[list(POSE)].to_numpy()[0])
    return np.asarray(place.inverse_jacobian[leg] * force)


def lengthening(leg: int, table: pd.DataFrame, structure: frames.Structure) -> np.ndarray:
    """Elongation of one leg (m) in each row, from the platform's motion."""
    place = posture(HEXAPOD, table[list(POSE)].to_numpy()[0])
    twists = [np.concatenate([d[:3], place.rates @ d[3:]]) for d in frames.deflections(structure, table)]
    return np.array([place.inverse_jacobian[leg] @ twist for twist in twists])


def test_a_bar_yields_by_its_force_over_EA_by_L() -> None:
    table = rows(along(2, 100.0), along(2, -250.0))
    expected = np.array([100.0, -250.0]) / HEXAPOD.stiffness[2]
    found = lengthening(2, table, frames.Structure(HEXAPOD))
    np.testing.assert_allclose(found, expected, rtol=1e-3)


def test_a_healthy_hexapod_is_the_base_model() -> None:
    table = rows(LOAD, -0.5 * LOAD)
    expected = base_matrices(HEXAPOD, table) @ (1.0 / HEXAPOD.stiffness)
    found = frames.deflections(frames.Structure(HEXAPOD), table)
    np.testing.assert_allclose(found, expected, rtol=2e-2, atol=2e-3 * np.abs(expected).max())


def law_of_leg(law: object, size: float, most: float, steps: int = 20, bar: str = "corotTruss") -> leg_kinds.LegsOf:
    stretch = most / float(HEXAPOD.stiffness[0])
    made = law(size, most, stretch, np.random.default_rng(1))  # type: ignore[operator]
    return leg_kinds.LegsOf(HEXAPOD, (0,), made, steps, bar)


def test_a_gap_opens_where_the_force_changes_sign() -> None:
    most, size = 300.0, 0.4
    table = rows(along(0, 300.0), along(0, 100.0), along(0, -200.0))
    found = lengthening(0, table, law_of_leg(leg_kinds.gap, size, most, bar="truss"))
    beyond = found - np.array([300.0, 100.0, -200.0]) / HEXAPOD.stiffness[0]
    assert beyond[0] == pytest.approx(beyond[1], abs=2e-9)
    assert beyond[0] - beyond[2] == pytest.approx(size * most / HEXAPOD.stiffness[0], rel=5e-3)


def test_a_contact_follows_hertz() -> None:
    most, size = 300.0, 0.5
    forces = np.array([30.0, 150.0, 300.0])
    found = lengthening(0, rows(*(along(0, f) for f in forces)), law_of_leg(leg_kinds.contact, size, most))
    stretch = most / HEXAPOD.stiffness[0]
    np.testing.assert_allclose(
        found, forces / HEXAPOD.stiffness[0] + size * stretch * (forces / most) ** (2 / 3), rtol=0.01
    )


def test_a_slip_leaves_half_a_loop() -> None:
    """After a load that slid, what stays without load is at most friction over the stiffness beside the clamp."""
    most, size = 300.0, 0.1
    found = lengthening(
        0, rows(*(along(0, f) for f in (0.0, 300.0, 0.0))), law_of_leg(leg_kinds.bouc_wen, size, most, steps=60)
    )
    limit = size * most / HEXAPOD.stiffness[0]
    assert 0.3 * limit < found[2] < limit
    assert found[1] == pytest.approx(300.0 * (1 - size) / HEXAPOD.stiffness[0], rel=0.02)


def test_a_viscous_member_creeps_with_its_time_constant() -> None:
    """A spring beside a spring in line with a dashpot, under a force that grows for a fifth of 50 s and stays."""
    quick, delay, force = 0.5, 60.0, 300.0

    def law(model: frames.Model, scaled: float, length: float) -> int:
        slow = model.material("Maxwell", quick * scaled, quick * scaled * delay, 1.0, 1.0)
        return model.material("Parallel", model.elastic(scaled), slow)

    table = rows(*(along(0, f) for f in (0.0, force, force, force)), times=[0.0, 50.0, 100.0, 250.0])
    found = lengthening(0, table, leg_kinds.LegsOf(HEXAPOD, (0,), law, 40)) * HEXAPOD.stiffness[0] / force
    slowness, ramp = delay * (1 + quick), 10.0  # time constant under constant force; the ramp's length
    share = 1 - quick / (1 + quick) * slowness / ramp * (np.exp(ramp / slowness) - 1) * np.exp(
        -np.array([50, 100, 250]) / slowness
    )
    np.testing.assert_allclose(found[1:], share, atol=0.02)


def test_a_crooked_leg_gives_way_as_its_bow_grows() -> None:
    """Pinned column with a sine bow e: it shortens further by π²e²/4L·((1 − P/Pcr)⁻² − 1) (Timoshenko, Gere 1961)."""
    place = posture(HEXAPOD, rows(LOAD)[list(POSE)].to_numpy()[0])
    length, push = float(place.lengths[0]), 300.0
    bow, critical = 4e-3 * length, 4.0 * push
    structure = leg_kinds.CrookedLeg(HEXAPOD, 0, bow, critical, 0.7)
    found = lengthening(0, rows(along(0, -push)), structure)[0] + push / HEXAPOD.stiffness[0]
    expected = -(np.pi**2) * bow**2 / (4 * length) * ((1 - push / critical) ** -2 - 1)
    assert found == pytest.approx(expected, rel=0.07)  # of six straight pieces


def test_spokes_bend_as_cantilevers() -> None:
    """Without a ring each leg gains the compliance r³/(3EI) = softness/k of its spoke, across the spoke."""
    structure = structure_kinds.BeamPlatform(HEXAPOD, 0.05, 1e-6)
    change = frames.deflections(structure, rows(LOAD)) - frames.deflections(frames.Structure(HEXAPOD), rows(LOAD))
    forces = np.linalg.solve(posture(HEXAPOD, rows(LOAD)[list(POSE)].to_numpy()[0]).inverse_jacobian.T, LOAD)
    energy = float(LOAD[:3] @ change[0, :3] + LOAD[3:] @ change[0, 3:])
    most = float(np.sum(forces**2) * 0.05 / HEXAPOD.stiffness.mean())
    assert 0.2 * most < energy < 1.3 * most


def test_a_stiff_frame_is_rigid_ground_and_a_soft_one_yields_in_proportion() -> None:
    frame = pynite_frames.draw_frame(HEXAPOD, np.random.default_rng(2))
    healthy = frames.deflections(frames.Structure(HEXAPOD), rows(LOAD))
    changes = [
        frames.deflections(pynite_frames.OnFrame(HEXAPOD, frame, softness), rows(LOAD)) - healthy
        for softness in (1e-5, 0.01, 0.02)
    ]
    assert np.abs(changes[0]).max() < 3e-3 * np.abs(healthy).max()
    np.testing.assert_allclose(
        changes[2], 2 * changes[1], atol=0.02 * np.abs(changes[2]).max() + 3e-3 * np.abs(healthy).max()
    )


ARM = arms.draw_arm(np.random.default_rng(3))
COMMAND = np.array([0.3, -0.4, 1.1, 0.2, 0.7, -0.5])
FORCE = np.array([6.0, -4.0, -9.0, 0.6, 0.3, -0.4])


def arm_rows(*loads: np.ndarray) -> pd.DataFrame:
    table = pd.DataFrame(np.array(loads), columns=list(WRENCH))
    table[list(JOINTS)] = COMMAND
    return table


def test_a_healthy_arm_is_the_base_model() -> None:
    table = arm_rows(FORCE, 0 * FORCE)
    _, matrices = base_deflections(arms.Stand(ARM), table)
    found = arms.states(arms.Stand(ARM), table).deflections()
    np.testing.assert_allclose(found[0], (matrices @ (1 / ARM.stiffness))[0], rtol=0.03, atol=1e-6)
    np.testing.assert_allclose(found[1], 0.0, atol=1e-12)


def test_an_arm_that_tilts_turns_about_its_foot() -> None:
    tilted = arms.Stand(ARM, arms.Parts(tilt=(2e5, 3e5, 4e5)))
    change = (
        arms.states(tilted, arm_rows(FORCE)).deflections() - arms.states(arms.Stand(ARM), arm_rows(FORCE)).deflections()
    )
    place, _, _ = arms.Stand(ARM).rigid(COMMAND)
    moment = (FORCE[3:] + np.cross(place, FORCE[:3])) / [2e5, 3e5, 4e5]
    np.testing.assert_allclose(change[0, 3:], moment, rtol=0.02, atol=2e-7)
    np.testing.assert_allclose(change[0, :3], np.cross(moment, place), rtol=0.03, atol=2e-7)


def test_a_buffer_pushes_a_joint_that_rests_against_it() -> None:
    joint, stiffness = 2, 1e-3 * float(ARM.stiffness[2])
    place, _ = arms.Stand(ARM).stand(COMMAND, FORCE)
    _, _, jacobian = arms.Stand(ARM).rigid(COMMAND)
    for low, acts in ((0.5, True), (1.5, False)):
        parts = arms.Parts(springs=(arms.Spring(joint, stiffness, -9.0, low, from_command=False),))
        moved, _ = arms.Stand(ARM, parts).stand(COMMAND, FORCE)
        back = acts * stiffness * (COMMAND[joint] - low) / (ARM.stiffness[joint] + stiffness)
        np.testing.assert_allclose(moved - place, -jacobian[:3, joint] * back, rtol=0.02, atol=3e-6)
