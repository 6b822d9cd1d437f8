"""`expdesign simulate`."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from expdesign.chain.recordings.reader import read_recordings
from expdesign.mechanics.elastostatics.maps import observation_matrix
from expdesign.mechanics.robots.robot_file import read_robot
from tests.commands.calls import CONFIG, ROBOT, call, model_file, plan_file, recordings_file

DEFLECTION = ["dx_m", "dy_m", "dz_m", "drx_rad", "dry_rad", "drz_rad"]


def test_without_noise_and_load_errors_it_is_a_times_c(tmp_path: Path) -> None:
    robot = read_robot(ROBOT)
    found = read_recordings(recordings_file(tmp_path, "--no-noise", "--no-load-errors"), robot)
    expected = observation_matrix(robot.jacobians(found.configurations), found.wrenches) @ robot.compliance
    np.testing.assert_allclose(found.deflections, expected, rtol=1e-12)
    assert found.deviations is not None
    np.testing.assert_allclose(found.deviations[0], [5e-7] * 3 + [2e-6] * 3)
    assert found.extra["note"].tolist() == ["first", "second", "third", "fourth"]


def test_a_seed_repeats_and_the_switches_leave_the_other_errors_as_they_are(tmp_path: Path) -> None:
    def deflections(*options: object) -> np.ndarray:
        return pd.read_csv(recordings_file(tmp_path, *options))[DEFLECTION].to_numpy()

    everything, again = deflections(), deflections()
    np.testing.assert_array_equal(everything, again)
    nothing = deflections("--no-noise", "--no-load-errors")
    noise = deflections("--no-load-errors") - nothing
    load = deflections("--no-noise") - nothing
    np.testing.assert_allclose(everything, nothing + noise + load, rtol=0.0, atol=1e-18)
    assert (noise != 0.0).all()
    assert (load != 0.0).all()


def test_a_model_deflects_as_it_predicts(tmp_path: Path) -> None:
    model = model_file(tmp_path)
    simulated, predicted = tmp_path / "simulated.csv", tmp_path / "predicted.csv"
    options = ("--model", model, "--no-noise", "--no-load-errors")
    assert call("simulate", CONFIG, plan_file(tmp_path), "--out", simulated, *options) == 0
    assert call("predict", model, plan_file(tmp_path), "--out", predicted) == 0
    first, second = pd.read_csv(simulated), pd.read_csv(predicted)
    np.testing.assert_allclose(first[DEFLECTION], second[DEFLECTION], rtol=1e-12)


def test_commands_of_compensate_have_no_unknown_columns(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model, commands = model_file(tmp_path), tmp_path / "commands.csv"
    targets = pd.read_csv(plan_file(tmp_path)).drop(columns=["note", "series"])
    targets.to_csv(tmp_path / "targets.csv", index=False)
    assert call("compensate", model, tmp_path / "targets.csv", "--out", commands) == 0
    capsys.readouterr()
    assert call("simulate", CONFIG, commands, "--model", model, "--out", tmp_path / "check.csv") == 0
    assert "without a meaning" not in capsys.readouterr().err


def test_rows_out_of_sequence_meet_their_own_load_errors(tmp_path: Path) -> None:
    model, plan = model_file(tmp_path), plan_file(tmp_path)
    frame = pd.read_csv(plan)
    frame["sequence"] = [3, 1, 4, 2]
    frame["series"] = [1, 1, 2, 3]
    frame.to_csv(plan, index=False)
    out = tmp_path / "simulated.csv"
    assert call("simulate", CONFIG, plan, "--out", out, "--model", model, "--no-noise") == 0
    with_model = pd.read_csv(out)[DEFLECTION].to_numpy()
    assert call("simulate", CONFIG, plan, "--out", out, "--no-noise") == 0
    base = pd.read_csv(out)[DEFLECTION].to_numpy()
    # The identified robot is within a few percent of the base model; a swapped load would differ by its own size.
    assert np.abs(with_model - base).max() < 0.2 * np.abs(base).max()


def test_a_plan_without_sequence_gets_one(tmp_path: Path) -> None:
    plan = plan_file(tmp_path)
    frame = pd.read_csv(plan).drop(columns=["sequence", "series"])
    frame.to_csv(plan, index=False)
    out = tmp_path / "simulated.csv"
    assert call("simulate", CONFIG, plan, "--out", out) == 0
    written = pd.read_csv(out)
    assert written["sequence"].tolist() == [1, 2, 3, 4]
    assert written["series"].tolist() == [1, 1, 2, 3]
