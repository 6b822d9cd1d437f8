"""`expdesign compensate`."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from tests.commands.calls import ROBOT, call, model_file, plan_file

from expdesign.robots.parallel import ParallelRobot
from expdesign.robots.robot_file import read_robot

POSE = ["x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"]
DEFLECTION = ["dx_m", "dy_m", "dz_m", "drx_rad", "dry_rad", "drz_rad"]


def test_the_command_plus_its_predicted_deflection_is_the_target(tmp_path: Path) -> None:
    model, targets, commands = model_file(tmp_path), plan_file(tmp_path), tmp_path / "commands.csv"
    assert call("compensate", model, targets, "--out", commands) == 0
    written, wanted = pd.read_csv(commands), pd.read_csv(targets)
    np.testing.assert_allclose(written[[f"target_{name}" for name in POSE]], wanted[POSE], atol=1e-15)
    assert written["note"].tolist() == wanted["note"].tolist()
    robot = read_robot(ROBOT)
    assert isinstance(robot, ParallelRobot)
    np.testing.assert_allclose(written[[f"leg{i}_m" for i in range(1, 7)]], robot.lengths(written[POSE].to_numpy()))
    predicted = tmp_path / "predicted.csv"
    # Rows of one series share one command, but every target has its own.
    written.assign(series=written["sequence"]).to_csv(commands, index=False)
    assert call("predict", model, commands, "--out", predicted, "--platform") == 0
    attained = written[POSE].to_numpy() + pd.read_csv(predicted)[DEFLECTION].to_numpy()
    # The payload's moment is taken at the target there and at the command here, 1e-5 rad apart.
    np.testing.assert_allclose(attained, wanted[POSE], atol=2e-8)
    assert (written[["sx_m", "srz_rad"]] > 0.0).all(axis=None)


def test_a_target_out_of_reach_ends_with_2_and_its_row(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model, targets, out = model_file(tmp_path), plan_file(tmp_path), tmp_path / "commands.csv"
    targets.write_text(targets.read_text().replace("3,2,-0.01,0,0,", "3,2,-0.01,0,0.2,"), encoding="utf-8")
    capsys.readouterr()
    assert call("compensate", model, targets, "--out", out) == 2
    message = capsys.readouterr().err
    assert "plan.csv, row 4" in message
    assert "beyond the robot's limits: leg" in message
    assert not out.exists()
