"""Inputs that look wrong and are taken, with a word where they are doubtful, plans among them; units of choice."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from expdesign.io.table import read_table
from tests.commands.calls import (
    CONFIG,
    ROBOT,
    Printed,
    call,
    model_file,
    plan_file,
    recordings_file,
    refusal,
    yaml_file,
)

BODY_HEADER = (
    "sequence,series,x_m,y_m,z_m,rx_rad,ry_rad,rz_rad,fx_N,fy_N,fz_N,mx_Nm,my_Nm,mz_Nm,drx_rad,dry_rad,srx_rad,sry_rad"
)


def test_a_small_compliance_may_be_negative_by_its_noise(tmp_path: Path) -> None:
    model = model_file(tmp_path)
    content = yaml.safe_load(model.read_text())
    del content["relative_compliance"]
    content["compliance"]["leg 1"] = -1e-9
    content["covariance"] = [[1e-18 * (row == column) for column in range(6)] for row in range(6)]
    yaml_file(model, content)
    assert call("predict", model, plan_file(tmp_path), "--out", tmp_path / "out.csv") == 0


def test_one_row_of_a_body_is_not_set_aside_as_an_outlier(tmp_path: Path) -> None:
    robot = yaml_file(tmp_path / "body.yaml", {"name": "b", "kind": "body"})
    row = "1,1,0,0,2,0,0,0,0,0,0,100,50,0,1e-4,5e-5,2e-6,2e-6"
    recordings = yaml_file(tmp_path / "b.csv", f"{BODY_HEADER}\n{row}\n")
    assert call("diagnose", robot, recordings, "--out", tmp_path / "out") == 0
    assert {"diagnosis.json", "report.html"} <= {path.name for path in (tmp_path / "out").iterdir()}


@pytest.mark.parametrize(
    ("column", "other", "said"),
    [
        ("dx_m", "dx_mmm", "dx_mmm (is `dx_m` meant?)\n"),
        ("time_s", "massN", "massN (is `mass_kg` meant?)\n"),
    ],
)
def test_a_column_that_is_nearly_known_is_compared_with_the_known_ones(
    tmp_path: Path, capsys: Printed, column: str, other: str, said: str
) -> None:
    frame = pd.read_csv(recordings_file(tmp_path)).assign(time_s=0.0, sx_m=1e-7, sy_m=1e-7)
    frame.rename(columns={column: other}).to_csv(tmp_path / "nearly.csv", index=False)
    assert call("check", tmp_path / "nearly.csv", "--robot", ROBOT) == 0
    assert said in capsys.readouterr().err


def test_names_of_files_may_be_in_any_script(tmp_path: Path) -> None:
    folder = tmp_path / "Kalibrierung Ø – 校准 ✓"
    folder.mkdir()
    plan = plan_file(folder)
    assert call("simulate", CONFIG, plan, "--out", folder / "Aufnahmen ä.csv") == 0
    assert call("identify", ROBOT, folder / "Aufnahmen ä.csv", "--out", folder / "Ergebnis – 结果") == 0
    assert "Aufnahmen ä.csv" in (folder / "Ergebnis – 结果" / "report.html").read_text(encoding="utf-8")


def stiffness(folder: Path) -> np.ndarray:
    found = json.loads((folder / "identification.json").read_text(encoding="utf-8"))["stiffness"]
    return np.array(list(found.values()))


def test_output_in_units_of_choice(tmp_path: Path) -> None:
    model, plan = model_file(tmp_path), plan_file(tmp_path)
    for command in ("predict", "compensate"):
        out, workbook = tmp_path / f"{command}.csv", tmp_path / f"{command}.xlsx"
        assert call(command, model, plan, "--out", out) == 0
        assert call(command, model, plan, "--out", workbook, "--units", "mm,mrad") == 0
        plain, other = read_table(out), read_table(workbook)
        assert plain.columns == other.columns
        names = ("x_m", "rx_rad", "sx_m", "srx_rad")
        np.testing.assert_allclose(other.numbers(names), plain.numbers(names), rtol=1e-12)
        assert set(other.written.values()) >= {"x_mm", "rx_mrad", *(["U_x_mm"] if command == "compensate" else [])}


WAYS = {
    "evaluate": (),
    "simulate": ("--out", "recordings.csv"),
    "sheet": ("--out", "sheet"),
    "montecarlo": ("--samples", "100", "--out", "repeated"),
}


def way(command: str, folder: Path) -> tuple[object, ...]:
    """What follows the plan in a call."""
    return tuple(folder / each if each in ("recordings.csv", "sheet", "repeated") else each for each in WAYS[command])


def changed(folder: Path, **columns: float | list[float]) -> Path:
    path = plan_file(folder)
    pd.read_csv(path).assign(**columns).to_csv(path, index=False)
    return path


@pytest.mark.parametrize("command", [command for command in WAYS if command != "simulate"])
def test_what_is_to_be_measured_has_to_be_reached(command: str, tmp_path: Path, capsys: Printed) -> None:
    """`simulate` says so, and goes on: where check readings are taken is no matter of the configuration."""
    plan, what = changed(tmp_path, z_m=0.3), "beyond the robot's limits: leg"
    assert f"row 2: the pose is {what}" in refusal(capsys, command, CONFIG, plan, *way(command, tmp_path))
    assert call("simulate", CONFIG, plan, *way("simulate", tmp_path)) == 0
    assert f"row 2: a point is {what}" in capsys.readouterr().err


@pytest.mark.parametrize("command", [command for command in WAYS if command != "simulate"])
def test_what_is_beyond_the_bounds_is_said(command: str, tmp_path: Path, capsys: Printed) -> None:
    plan = changed(tmp_path, mass_kg=[26.5, 40.0, 26.5, 30.0], com_z_m=0.12000001)
    assert call(command, CONFIG, plan, *way(command, tmp_path)) == 0
    said = capsys.readouterr().err
    assert "rows 3, 5: mass_kg is 40, beyond the bounds of the configuration (5 to 26.5)" in said
    assert said.count("beyond the bounds") == 1


def test_degrees_in_a_plan_are_asked_about(tmp_path: Path, capsys: Printed) -> None:
    assert call("evaluate", CONFIG, changed(tmp_path, rz_rad=6.25)) == 0
    assert "row 2: rz_rad would be 6.25 rad, i.e. 358°. Is it in degrees?" in capsys.readouterr().err
