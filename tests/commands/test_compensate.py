"""`expdesign compensate`."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

import expdesign as xd
from expdesign.app.api.configuration import problem_of
from expdesign.chain.chain import Chain
from expdesign.chain.effects.legs.transmission import LegBacklash
from expdesign.chain.models.model_file import read_model
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.robots.robot_file import read_robot
from expdesign.planning.target_table import targets_table
from tests.commands.calls import CONFIG, ROBOT, Printed, call, model_file, plan_file, refusal

POSE = ["x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"]
DEFLECTION = ["dx_m", "dy_m", "dz_m", "drx_rad", "dry_rad", "drz_rad"]


def test_the_command_plus_its_predicted_deflection_is_the_target(tmp_path: Path, capsys: Printed) -> None:
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
    said = capsys.readouterr().err
    for file in (targets, commands):
        assert f"{file}: columns without a meaning here, kept but not used: note\n" in said
    attained = written[POSE].to_numpy() + pd.read_csv(predicted)[DEFLECTION].to_numpy()
    # The payload's moment is taken at the target there and at the command here, 1e-5 rad apart.
    np.testing.assert_allclose(attained, wanted[POSE], atol=2e-8)
    assert (written[["sx_m", "srz_rad"]] > 0.0).all(axis=None)


def targets_with(folder: Path, **changes: object) -> Path:
    """The plan's rows as targets, the first with other values."""
    frame = pd.read_csv(plan_file(folder), dtype={"mass_kg": float})
    for name, value in changes.items():
        frame.loc[0, name] = value
    path = folder / "targets.csv"
    frame.to_csv(path, index=False)
    return path


def test_corrections_and_what_to_expect_are_written_and_said(tmp_path: Path, capsys: Printed) -> None:
    model, targets, commands = model_file(tmp_path), plan_file(tmp_path), tmp_path / "commands.csv"
    capsys.readouterr()
    assert call("compensate", model, targets, "--out", commands) == 0
    said = capsys.readouterr().out
    written = pd.read_csv(commands)
    moved = written[POSE[:3]].to_numpy() - written[[f"target_{name}" for name in POSE[:3]]].to_numpy()
    np.testing.assert_allclose(written["correction_m"], np.linalg.norm(moved, axis=1), rtol=1e-9)
    # About an axis near a coordinate's the angle is the change of that coordinate; here it is a few parts in 10 off.
    turned = written[POSE[3:]].to_numpy() - written[[f"target_{name}" for name in POSE[3:]]].to_numpy()
    np.testing.assert_allclose(written["correction_rad"], np.linalg.norm(turned, axis=1), rtol=0.2)
    np.testing.assert_allclose(written["U_z_m"], 2.0 * written["sz_m"], rtol=1e-9)
    largest = 1e6 * written["correction_m"].max(), 1e6 * written["correction_rad"].max()
    length = 1e6 * written[["U_x_m", "U_y_m", "U_z_m"]].to_numpy().max()
    assert f"largest correction {largest[0]:.3g} µm, {largest[1]:.3g} µrad; expected U {length:.3g} µm" in said
    assert written["beyond_calibration"].isna().all()
    assert len(said.splitlines()) == 1 + 4 + 2


def test_targets_that_are_doubtful_are_computed_and_asked_about(tmp_path: Path, capsys: Printed) -> None:
    model, out = model_file(tmp_path), tmp_path / "commands.csv"
    capsys.readouterr()
    assert call("compensate", model, targets_with(tmp_path, mass_kg=265.0), "--out", out) == 0
    assert "row 2: the mass is 265 kg, 10 times the largest that was calibrated" in capsys.readouterr().err


def test_extrapolation_is_said_for_its_row(tmp_path: Path, capsys: Printed) -> None:
    model, out = model_file(tmp_path), tmp_path / "commands.csv"
    capsys.readouterr()
    assert call("compensate", model, targets_with(tmp_path, mass_kg=40.0, y_m=-0.02), "--out", out) == 0
    said = capsys.readouterr().out
    beyond = pd.read_csv(out)["beyond_calibration"].fillna("").tolist()
    assert beyond[0].startswith("y_m -0.02 (recorded 0 to 0.02)")
    assert "mass_kg 40 (recorded up to 26.5)" in beyond[0]
    assert beyond[1:] == ["", "", ""]
    assert beyond[0] in said
    assert "1 of 4 targets beyond what was calibrated" in said


def test_a_configuration_gives_its_targets_and_has_to_be_of_the_robot(tmp_path: Path, capsys: Printed) -> None:
    model, out = model_file(tmp_path), tmp_path / "commands.csv"
    assert call("compensate", model, CONFIG, "--out", out) == 0
    written = pd.read_csv(out)
    targets = yaml.safe_load(CONFIG.read_text(encoding="utf-8"))["targets"]
    np.testing.assert_allclose(written[[f"target_{name}" for name in POSE]], [target["pose"] for target in targets])
    np.testing.assert_allclose(written["mass_kg"], [target["payload"]["mass_kg"] for target in targets])
    other = yaml.safe_load(CONFIG.read_text(encoding="utf-8"))
    other["robot"] = yaml.safe_load(ROBOT.read_text(encoding="utf-8"))
    other["robot"]["home"][2] += 0.02
    (tmp_path / "other.yaml").write_text(yaml.safe_dump(other), encoding="utf-8")
    capsys.readouterr()
    out = tmp_path / "others.csv"
    message = refusal(capsys, "compensate", model, tmp_path / "other.yaml", "--out", out)
    assert "home is 20 mm apart" in message
    assert "model.yaml" in message
    assert call("compensate", model, tmp_path / "other.yaml", "--out", out, "--other-robot") == 0


def test_a_model_keeps_the_ranges_of_its_recordings(tmp_path: Path) -> None:
    content = yaml.safe_load(model_file(tmp_path).read_text(encoding="utf-8"))["calibrated"]
    assert content["x_m"] == [-0.01, 0.01]
    assert content["mass_kg"] == [0.0, 26.5]
    assert content["com_y_m"] == [-0.05, 0.05]
    assert content["force_N"] == pytest.approx([0.0, 26.5 * 9.80665])
    assert content["moment_Nm"][1] == pytest.approx(26.5 * 9.80665 * np.hypot(0.1, 0.05), rel=0.05)


def test_springs_are_calibrated_wherever_the_configuration_measures_and_added_physics_where_it_was_recorded(
    tmp_path: Path,
) -> None:
    """The plan stays within x ± 10 mm, the configuration within ± 30 mm, and its targets are at ± 20 mm."""
    model = read_model(model_file(tmp_path))
    own, alone = (xd.compensate(model, given).frame for given in (CONFIG, targets_table(problem_of(CONFIG)).frame))
    assert own["beyond_calibration"].isna().all()
    assert alone["beyond_calibration"].str.startswith("x_m").all()
    play = LegBacklash.from_text(model.chain.robot, "leg 1", "middle")
    values, covariance = np.append(model.values, 2e-6), np.pad(model.covariance, (0, 1))
    added = replace(model, chain=Chain(model.chain.robot, (play,)), values=values, covariance=covariance, subspace=None)
    assert xd.compensate(added, CONFIG).frame["beyond_calibration"].str.startswith("x_m").all()
