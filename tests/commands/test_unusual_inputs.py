"""Inputs that look wrong or have other units and forms, and are taken, with a word where they are doubtful."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

import expdesign as xd
from expdesign.io.table import read_table
from expdesign.io.written import Purpose
from expdesign.report.result import TableResult
from tests.commands.calls import CONFIG, ROBOT, Printed, call, model_file, plan_file, recordings_file, yaml_file

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


def test_recordings_in_other_units_and_forms_identify_the_same(tmp_path: Path, capsys: Printed) -> None:
    plain = recordings_file(tmp_path)
    assert call("identify", ROBOT, plain, "--out", tmp_path / "plain") == 0
    frame = xd.load(plain)
    assert isinstance(frame, pd.DataFrame)
    result = TableResult(frame, purpose=Purpose("test"))
    forms = [result.save(tmp_path / "units.csv", "mm,mrad,g"), result.save(tmp_path / "units.xlsx", "um,deg")]
    german = tmp_path / "german.csv"
    german.write_bytes(forms[0].read_text().replace(",", ";").replace(".", ",").replace("\n", "\r\n").encode("cp1252"))
    for path in [*forms, german]:
        capsys.readouterr()
        out = tmp_path / f"from-{path.name}"
        assert call("identify", ROBOT, path, "--out", out) == 0
        assert "columns converted from " in capsys.readouterr().err
        np.testing.assert_allclose(stiffness(out), stiffness(tmp_path / "plain"), rtol=1e-9)


def test_configuration_and_robot_in_other_units_give_the_same(tmp_path: Path, capsys: Printed) -> None:
    text = CONFIG.read_text(encoding="utf-8").replace("robots/", f"{ROBOT.parent}/")
    changed = text.replace("x_m: [-0.03, 0.03]", 'x_m: ["-30 mm", 3 cm]').replace("5.0e-7", "0.5 µm")
    assert changed != text
    (tmp_path / "config.yaml").write_text(changed, encoding="utf-8")
    plan = plan_file(tmp_path)
    found = []
    for config in (CONFIG, tmp_path / "config.yaml"):
        capsys.readouterr()
        assert call("evaluate", config, plan, "--json") == 0
        found.append(json.loads(capsys.readouterr().out)["duir"])
    assert found[0] == found[1]


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
