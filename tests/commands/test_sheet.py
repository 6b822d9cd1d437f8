"""`expdesign sheet`: filled in by a person, it is what `identify` reads."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from openpyxl import load_workbook

import expdesign as xd
from expdesign.io.table import read_table
from tests.commands.calls import ROBOT, Printed, call, config_file

POSES = [(0.01, 0, 0, 0, 0, 0), (-0.02, 0.01, 0, 0.1, 0, 0), (0, 0, 0.01, 0, 0.1, 0)]
AXES = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")


def costly(folder: Path, *, shared: bool) -> Path:
    costs = {"pose_change": 2, "mass_change": "10 min", "reading": "30 s"}
    return config_file(folder, {"experiment.costs": costs, "experiment.deflection_noise.shared_reference": shared})


def plan_file(folder: Path) -> Path:
    lines = [",".join(("sequence", "series", *AXES, "mass_kg", "com_x_m", "com_y_m", "com_z_m"))]
    for row, (pose, mass) in enumerate([(0, 26.5), (1, 10), (0, 10), (2, 26.5), (1, 26.5), (0, 26.5), (2, 5)]):
        lines.append(f"{row + 1},{pose + 1},{','.join(map(str, POSES[pose]))},{mass},0.1,{0.05 * (row % 3 - 1)},0.12")
    path = folder / "plan.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("shared", [True, False])
def test_the_workbook_filled_in_identifies_what_deflections_do(shared: bool, tmp_path: Path, capsys: Printed) -> None:
    config, plan = costly(tmp_path, shared=shared), plan_file(tmp_path)
    assert call("sheet", config, plan, "--out", tmp_path / "sheet", "--units", "mm,mrad") == 0
    sheet = xd.load(tmp_path / "sheet" / "sheet.xlsx")
    assert isinstance(sheet, pd.DataFrame)
    references = 3 if shared else 7
    assert len(sheet) == 7 + references
    recordings = xd.simulate(config, plan, seed=4).frame
    fill_in(tmp_path / "sheet" / "sheet.xlsx", recordings, empty=6)
    capsys.readouterr()
    filled = tmp_path / "sheet" / "sheet.xlsx"
    assert call("identify", ROBOT, filled, "--out", tmp_path / "filled") == 0
    notes = capsys.readouterr().err
    assert "1 row left out: no measured value" in notes
    assert "reference rows" in notes
    kept = recordings.drop(index=6).sort_values("series", kind="stable")
    kept["sequence"] = np.arange(1, len(kept) + 1)
    kept.to_csv(tmp_path / "direct.csv", index=False)
    assert call("identify", ROBOT, tmp_path / "direct.csv", "--out", tmp_path / "direct") == 0
    found = [json.loads((tmp_path / name / "identification.json").read_text()) for name in ("filled", "direct")]
    for name, interval in found[0]["stiffness"].items():
        np.testing.assert_allclose(interval, found[1]["stiffness"][name], rtol=1e-6)
    assert found[0]["chi2"] == pytest.approx(found[1]["chi2"], rel=1e-5)
    assert found[0]["dof"] == found[1]["dof"]


def fill_in(path: Path, recordings, empty: int) -> None:  # type: ignore[no-untyped-def]
    """Write into the empty cells what an instrument with a zero of its own would show; one row stays empty."""
    book = load_workbook(path)
    cells = book["recordings"]
    header = [cell.value for cell in cells[1]]
    zero = np.random.default_rng(5).normal(scale=0.01, size=6)
    deflections = recordings[[f"d{name}" for name in AXES]].to_numpy()
    for row in cells.iter_rows(min_row=2):
        values = dict(zip(header, row, strict=True))
        planned = values["plan_row"].value - 1
        loaded = values["mass_kg"].value > 0
        if loaded and planned == empty:
            continue
        shown = zero + (deflections[planned] if loaded else 0.0)
        for axis, name in enumerate(AXES):
            column = f"reading_{name}".replace("_rad", "_mrad") if axis > 2 else f"reading_{name}"[:-2] + "_mm"
            assert values[column].value is None
            values[column].value = float(shown[axis] * 1e3)
    book.save(path)


def test_order_time_and_page(tmp_path: Path, capsys: Printed) -> None:
    config, plan = costly(tmp_path, shared=True), plan_file(tmp_path)
    assert call("sheet", config, plan, "--out", tmp_path / "sheet") == 0
    said = capsys.readouterr().out
    table = read_table(tmp_path / "sheet" / "sheet.csv")
    loads = table.numbers(("mass_kg", "com_y_m"))
    loads[loads[:, 0] == 0.0] = 0.0
    changes = int((np.diff(loads, axis=0) != 0.0).any(axis=1).sum())
    assert f"Time: {3 * 2 + changes * 10 + 10 * 0.5:.4g} min" in said
    assert "row by row as planned" in said
    assert np.count_nonzero(np.diff(table.integers("series"))) == 2
    page = (tmp_path / "sheet" / "sheet.html").read_text(encoding="utf-8")
    assert page.count("<tr class=") == 10
    assert f"expdesign identify {ROBOT} {tmp_path / 'sheet' / 'sheet.xlsx'} --out" in page
    assert "http" not in page
    assert len(page) < 60_000


@pytest.mark.parametrize("shared", [True, False])
def test_the_steps_set_the_pose_as_often_as_is_counted(shared: bool, tmp_path: Path) -> None:
    """Also where a second series has the pose of the first: it is set anew, since its readings count as independent."""
    plan = pd.read_csv(plan_file(tmp_path))
    plan.loc[plan["sequence"] == 6, "series"] = 4
    made = xd.sheet(costly(tmp_path, shared=shared), plan)
    assert made.text["do"].str.contains("set the pose").sum() == made.steps.pose_changes == (4 if shared else 3)
    assert made.text["do"].str.contains("set the pose anew").any() == shared


def test_numbers_in_the_files_are_those_of_the_page(tmp_path: Path) -> None:
    """0.1018131 rad are 5.83346° to within 1e-6 rad, in the page as in the table; deviations are not rounded."""
    config, plan = costly(tmp_path, shared=True), plan_file(tmp_path)
    text = plan.read_text(encoding="utf-8").replace(
        "-0.02,0.01,0,0.1,0,0", "-0.02,0.010000000123,0,0.1018131234567,0,0"
    )
    plan.write_text(text, encoding="utf-8")
    assert call("sheet", config, plan, "--out", tmp_path / "sheet", "--units", "mm,deg") == 0
    table = pd.read_csv(tmp_path / "sheet" / "sheet.csv")
    page = (tmp_path / "sheet" / "sheet.html").read_text(encoding="utf-8")
    assert set(table["y_mm"]) == {0.0, 10.0}
    assert set(table["rx_deg"]) == {0.0, 5.83346}
    assert ">5.83346<" in page
    assert (table["sx_mm"] > 0.0).all()
