"""Geometric calibration against forward kinematics that are not the library's."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from benchmarks.geometry.experiment import (
    NOISE,
    POSE,
    ROBOT,
    Plan,
    cramer_rao,
    drawn_machine,
    empty_recordings,
    held_out_plan,
    measured,
    paired_plan,
    robot,
    sensitivities,
)
from benchmarks.geometry.machine import Array, Machine
from benchmarks.geometry.study import compensated, model_of, points_of, repeated
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

import expdesign as xd
from expdesign.chain.chain import Chain
from expdesign.chain.effects.legs.geometry import leg_geometry
from expdesign.chain.readings.reading import MeasuredPose
from expdesign.chain.row import row_data
from expdesign.errors import NotIdentifiableError
from expdesign.estimation.compensation.prediction import predict
from expdesign.estimation.identify import identify
from expdesign.report.remark_texts import sentences

HEXAPOD = robot()
PLAN, HELD_OUT = paired_plan(20, 1), held_out_plan(20, 1)


def _experiment(seed: int) -> tuple[Machine, Array, np.random.Generator]:
    random = np.random.default_rng(seed)
    machine, errors = drawn_machine(HEXAPOD, random)
    return machine, errors, random


def _frame(plan: Plan, poses: Array) -> pd.DataFrame:
    frame = plan.table()
    frame[[f"measured_{name}" for name in POSE]] = poses
    frame[[f"s{name}" for name in POSE]] = np.broadcast_to(NOISE, poses.shape)
    return frame


def test_the_chain_at_the_true_parameters_is_the_machine() -> None:
    machine, errors, _ = _experiment(1)
    chain = Chain(HEXAPOD, (leg_geometry(HEXAPOD),), reading=MeasuredPose())
    values = np.concatenate([1.0 + errors[42:], errors[:42]])
    rows = row_data(empty_recordings(HEXAPOD, PLAN), HEXAPOD)
    difference = np.abs(chain.predict(rows, values) - machine.poses(PLAN.commands, PLAN.wrenches))
    assert difference[::2].max() < 1e-12  # without load the kinematics are exact
    assert difference[1::2].max() < 2e-7  # deflections are linear in the load
    derivatives = chain.predict_with_sensitivities(rows, np.concatenate([np.ones(6), np.zeros(42)]))[1]
    expected = sensitivities(HEXAPOD, PLAN, np.zeros(48))
    np.testing.assert_allclose(derivatives[..., 6:], expected[..., :42], atol=2e-3)
    # What remains is the second order of the deflection, 1e-4 of it.
    np.testing.assert_allclose(derivatives[..., :6], expected[..., 42:], atol=2e-7)


def test_parameters_scatter_as_their_covariance_says() -> None:
    statistics = []
    for seed in range(6):
        machine, errors, random = _experiment(seed)
        recordings = measured(empty_recordings(HEXAPOD, PLAN), machine.poses(PLAN.commands, PLAN.wrenches), random)
        result = identify(HEXAPOD, recordings)
        assert result.calibration == "both"
        off = result.fit.values - np.concatenate([1.0 + errors[42:], errors[:42]])
        statistics.append(float(off @ np.linalg.solve(result.fit.covariance, off)))
    assert 1e-4 < chi2.sf(sum(statistics), 48 * len(statistics)) < 1.0 - 1e-4


def test_predicted_deviations_are_the_cramer_rao_bound() -> None:
    machine, _, random = _experiment(3)
    recordings = measured(empty_recordings(HEXAPOD, PLAN), machine.poses(PLAN.commands, PLAN.wrenches), random)
    prediction = predict(model_of(identify(HEXAPOD, recordings)), points_of(HEXAPOD, HELD_OUT))
    bound = np.sqrt(np.einsum("nii->ni", cramer_rao(HEXAPOD, PLAN, HELD_OUT)))
    np.testing.assert_allclose(prediction.deviations, bound, rtol=0.1)


def test_geometry_alone_is_read_off_the_rows_without_load() -> None:
    machine, _, random = _experiment(4)
    unloaded = Plan(np.random.default_rng(5).uniform(-0.02, 0.02, (40, 6)), np.zeros((40, 6)))
    recordings = measured(
        empty_recordings(HEXAPOD, unloaded), machine.poses(unloaded.commands, unloaded.wrenches), random
    )
    result = identify(HEXAPOD, recordings)
    assert result.calibration == "geometric"
    held_out = Plan(HELD_OUT.commands * 0.5, np.zeros((20, 6)))
    prediction = predict(model_of(result), points_of(HEXAPOD, held_out))
    off = (prediction.deflections - machine.poses(held_out.commands, held_out.wrenches)) / prediction.deviations
    assert np.sqrt((off**2).mean()) < 2.0


def test_unknown_frames_cost_parameters_and_no_prediction() -> None:
    machine, _, random = _experiment(6)
    shift, turn = np.array([1e-3, -2e-3, 5e-4]), Rotation.from_rotvec([1e-3, -5e-4, 2e-3])
    place, target = np.array([5e-4, 1e-3, -1e-3]), Rotation.from_rotvec([-1e-3, 1e-3, 5e-4])

    def seen(poses: Array) -> Array:
        own = Rotation.from_euler("xyz", poses[:, 3:])
        position = turn.inv().apply(HEXAPOD.home + poses[:, :3] + own.apply(place) - shift) - HEXAPOD.home
        return np.hstack([position, (turn.inv() * own * target).as_euler("xyz")])

    recordings = measured(empty_recordings(HEXAPOD, PLAN), seen(machine.poses(PLAN.commands, PLAN.wrenches)), random)
    result = identify(HEXAPOD, recordings, frames_known=False)
    assert any("determine only combinations of" in text for text in sentences(result.suspicions))
    assert result.goodness.p_value is not None
    assert result.goodness.p_value > 1e-3
    prediction = predict(model_of(result), points_of(HEXAPOD, HELD_OUT))
    off = (prediction.deflections - seen(machine.poses(HELD_OUT.commands, HELD_OUT.wrenches))) / prediction.deviations
    assert np.sqrt((off**2).mean()) < 2.0
    # Without loads, which act in the frames of the robot, the frames are a gauge freedom of the geometry.
    unloaded = Plan(PLAN.commands, np.zeros_like(PLAN.wrenches))
    empty, points = (
        empty_recordings(HEXAPOD, unloaded),
        points_of(HEXAPOD, replace(HELD_OUT, wrenches=HELD_OUT.wrenches * 0)),
    )
    poses = machine.poses(unloaded.commands, unloaded.wrenches)
    free = identify(HEXAPOD, measured(empty, seen(poses), random), frames_known=False)
    held = identify(HEXAPOD, measured(empty, poses, random))
    deviations = [predict(model_of(found), points).deviations for found in (free, held)]
    np.testing.assert_allclose(deviations[0], deviations[1], rtol=0.02)


def test_positions_alone_determine_the_geometry() -> None:
    machine, _, random = _experiment(7)
    plan = paired_plan(40, 7)
    frame = _frame(plan, machine.poses(plan.commands, plan.wrenches) + NOISE * random.standard_normal((80, 6)))
    angles = [name for name in frame.columns if name.endswith("_rad") and name.startswith(("measured_", "s"))]
    result = xd.identify(ROBOT, frame.drop(columns=[name for name in angles if name not in POSE])).result
    assert list(result.recordings.axes) == [0, 1, 2]
    prediction = predict(model_of(result), points_of(HEXAPOD, HELD_OUT))
    off = (prediction.deflections - machine.poses(HELD_OUT.commands, HELD_OUT.wrenches)) / prediction.deviations
    assert np.sqrt((off**2).mean()) < 2.0


def test_drawings_help_where_poses_are_few() -> None:
    machine, _, random = _experiment(8)
    few = Plan(PLAN.commands[:10:2], np.zeros((5, 6)))
    recordings = measured(empty_recordings(HEXAPOD, few), machine.poses(few.commands, few.wrenches), random)
    with pytest.raises(NotIdentifiableError, match="30 readings of 5 poses cannot determine 42"):
        identify(HEXAPOD, recordings)
    again = Plan(np.repeat(PLAN.commands[:2:2], 20, axis=0), np.zeros((20, 6)))
    with pytest.raises(NotIdentifiableError, match="determine 6 of 42 combinations"):
        identify(HEXAPOD, empty_recordings(HEXAPOD, again))
    known = robot()
    known.geometry_std = 2e-4
    result = identify(known, replace(recordings))
    assert result.geometry is not None
    held_out = Plan(HELD_OUT.commands * 0.5, np.zeros((20, 6)))
    prediction = predict(model_of(result), points_of(HEXAPOD, held_out))
    truth = machine.poses(held_out.commands, held_out.wrenches)
    before = np.sqrt(((truth - held_out.commands) ** 2).mean())
    assert np.sqrt(((prediction.deflections - truth) ** 2).mean()) < 0.2 * before
    assert np.sqrt((((prediction.deflections - truth) / prediction.deviations) ** 2).mean()) < 2.0


def test_a_model_file_carries_the_geometry(tmp_path: Path) -> None:
    machine, _, random = _experiment(9)
    poses = machine.poses(PLAN.commands, PLAN.wrenches) + NOISE * random.standard_normal(PLAN.commands.shape)
    identified = xd.identify(ROBOT, _frame(PLAN, poses), frames="unknown")
    identified.save(tmp_path / "found")
    record = identified.record
    assert len(record["geometry"]) == 42
    model = tmp_path / "found" / "model.yaml"
    wanted = HELD_OUT.table()
    filled = xd.predict(model, wanted).frame
    here = predict(identified.model, points_of(HEXAPOD, HELD_OUT))
    np.testing.assert_array_equal(filled[[f"measured_{name}" for name in POSE]].to_numpy(), here.deflections)
    deflections = xd.predict(model, wanted.drop(columns="kind")).frame
    unloaded = replace(HELD_OUT, wrenches=np.zeros_like(HELD_OUT.wrenches))
    truth = machine.poses(HELD_OUT.commands, HELD_OUT.wrenches) - machine.poses(unloaded.commands, unloaded.wrenches)
    assert np.abs(deflections[["dx_m", "dy_m", "dz_m"]].to_numpy() - truth[:, :3]).max() < 2e-5
    commands = xd.compensate(model, wanted)
    attained = machine.poses(commands.compensation.commands, HELD_OUT.wrenches)
    assert np.abs((attained - HELD_OUT.commands) / commands.compensation.deviations).max() < 5.0


@pytest.mark.slow
def test_diagnosis_finds_what_the_geometry_leaves_over() -> None:
    """A screw whose length errs by 30 µm over a pitch of 4 mm, on a machine whose geometry is unknown."""
    machine, _, random = _experiment(0)
    plan = paired_plan(40, 1)
    length = HEXAPOD.lengths(plan.commands)[:, 2]
    error = 3e-5 * np.sin(2.0 * np.pi * length / 4e-3 + 0.5)
    moved = [replace(machine, length_errors=machine.length_errors + np.eye(6)[2] * value) for value in error]
    rows = zip(moved, plan.commands, plan.wrenches, strict=True)
    poses = np.vstack([each.poses(command[None], wrench[None]) for each, command, wrench in rows])
    record = xd.diagnose(ROBOT, _frame(plan, poses + NOISE * random.standard_normal(poses.shape))).record
    assert record["verdict"] == "explained"
    found = {(effect["physics"], effect["component"]): effect["parameters"] for effect in record["effects"]}
    assert set(found) == {("joint_position_error", "geometry"), ("encoder_periodic_error", "leg 3")}
    screw = found["encoder_periodic_error", "leg 3"]
    assert screw["pitch_m"][0] == pytest.approx(4e-3, rel=0.01)
    assert screw["amplitude_m"][0] == pytest.approx(3e-5, rel=0.15)


@pytest.mark.slow
def test_repeated_experiments() -> None:
    """Coverage of 95 ± 1.5 % and an error within 1.05 of the Cramér-Rao bound."""
    found = repeated(400, 2)
    for what in ("geometry", "compliance", "held_out_poses"):
        assert abs(found["coverage"][what] - 0.95) < 0.015
    assert found["ratio_to_bound"] < 1.05
    assert found["gain"] > 1.0


@pytest.mark.slow
def test_what_remains_after_compensation() -> None:
    found = compensated(20, 2)
    assert found["before"]["um"] > 300.0
    assert found["after"]["um"] == pytest.approx(found["stated"]["um"], rel=0.15)
