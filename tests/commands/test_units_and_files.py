"""The commands with files in other units and forms: the same results, and one message where a file is wrong."""

import json
from pathlib import Path

import numpy as np
import pandas as pd

from expdesign.io.table import read_table
from tests.commands.calls import CONFIG, ROBOT, Printed, call, model_file, plan_file, recordings_file


def stiffness(folder: Path) -> np.ndarray:
    found = json.loads((folder / "identification.json").read_text(encoding="utf-8"))["stiffness"]
    return np.array(list(found.values()))


def test_recordings_in_other_units_and_forms_identify_the_same(tmp_path: Path, capsys: Printed) -> None:
    plain = recordings_file(tmp_path)
    assert call("identify", ROBOT, plain, "--out", tmp_path / "plain") == 0
    import expdesign as xd  # noqa: PLC0415
    from expdesign.app.api.result import TableResult  # noqa: PLC0415
    from expdesign.io.written import Purpose  # noqa: PLC0415

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
