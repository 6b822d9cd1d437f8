"""`expdesign register`: from a tracker's lists to a stiffness."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

import expdesign as xd
from expdesign.errors import InputError
from expdesign.io.table import read_table
from expdesign.mechanics.robots.robot import Robot
from expdesign.mechanics.robots.robot_file import read_robot
from tests.commands.calls import CONFIG, ROBOT, Printed, call, config_file, plan_file, refusal, yaml_file
from tests.recordings.test_registered_deflections import INSTRUMENT, MARKERS

NOISE = 1e-6
POSE = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")
DEFLECTION = ("dx_m", "dy_m", "dz_m", "drx_rad", "dry_rad", "drz_rad")


def robot_file(folder: Path, **changes: object) -> Path:
    content = yaml.safe_load(ROBOT.read_text(encoding="utf-8"))
    content["markers"] = {name: place.tolist() for name, place in MARKERS.items()}
    return yaml_file(folder / "robot.yaml", content | changes)


def listed(robot: Robot, pose: np.ndarray, group: str, generator: np.random.Generator) -> str:
    base = np.array(list(MARKERS.values())) @ robot.jacobians(pose).rotation.T + robot.position(pose)
    seen = (base - INSTRUMENT[1]) @ INSTRUMENT[0] + generator.normal(scale=NOISE, size=(len(MARKERS), 3))
    rows = zip(MARKERS, seen * 1e3, strict=True)
    return "".join(f"Job::{group}::{name} {x:.7f} {y:.7f} {z:.7f}\n" for name, (x, y, z) in rows)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plan of four rows in three series, and what a tracker wrote of it."""
    folder = tmp_path_factory.mktemp("register")
    plan = plan_file(folder)
    true = xd.simulate(CONFIG, plan, noise=False, load_errors=False).frame
    robot = read_robot(robot_file(folder))
    generator = np.random.default_rng(3)
    text = {"unloaded": "// Units: mm\n", "loaded": "// Units: mm\n"}
    for number in dict.fromkeys(true["series"]):
        row = true[true["series"] == number].iloc[0]
        text["unloaded"] += listed(robot, row[list(POSE)].to_numpy(float), f"unloaded-{number}", generator)
    for _, row in true.iterrows():
        pose = row[list(POSE)].to_numpy(float) + row[list(DEFLECTION)].to_numpy(float)
        text["loaded"] += listed(robot, pose, f"loaded-{row['sequence']:.0f}", generator)
    for name, content in text.items():
        (folder / f"{name}.txt").write_text(content, encoding="utf-8")
    true.to_csv(folder / "true.csv", index=False)
    return folder


def test_from_two_lists_to_stiffness(folder: Path) -> None:
    out = folder / "recordings.csv"
    lists = (folder / "unloaded.txt", folder / "loaded.txt")
    options = ("--std", "1 um", "--record", folder / "record.json")
    assert call("register", folder / "robot.yaml", folder / "plan.csv", *lists, "--out", out, *options) == 0
    found, true = read_table(out), read_table(folder / "true.csv")
    errors = found.numbers(DEFLECTION) - true.numbers(DEFLECTION)
    stated = found.numbers(("sx_m", "sy_m", "sz_m", "srx_rad", "sry_rad", "srz_rad"))
    assert np.abs(errors / stated).max() < 4.0
    covariance = np.array(json.loads((folder / "record.json").read_text(encoding="utf-8"))["covariance"])
    np.testing.assert_allclose(np.sqrt(np.diagonal(covariance, axis1=1, axis2=2)), stated, rtol=1e-12)
    assert call("identify", folder / "robot.yaml", out, "--out", folder / "identified") == 0
    record = json.loads((folder / "identified" / "identification.json").read_text(encoding="utf-8"))
    for estimate, _, _ in record["stiffness"].values():
        assert abs(estimate / 5.24e6 - 1.0) < 0.2
    assert record["p_value"] > 1e-3
    assert record["shared_reference"]


def test_without_a_deviation_it_is_estimated(folder: Path, capsys: Printed) -> None:
    lists = (folder / "unloaded.txt", folder / "loaded.txt")
    assert call("register", folder / "robot.yaml", folder / "plan.csv", *lists, "--out", folder / "e.csv") == 0
    text = capsys.readouterr().out.split("estimated from the residuals: ")[1]
    assert 0.6 < float(text.split()[0]) < 1.4  # 24 degrees of freedom: ±15 % (one standard deviation)


def test_positions_of_markers(folder: Path) -> None:
    out = folder / "positions.csv"
    lists = (folder / "unloaded.txt", folder / "loaded.txt")
    arguments = (folder / "robot.yaml", folder / "plan.csv", *lists, "--out", out, "--positions", "--std", "1 um")
    assert call("register", *arguments) == 0
    table = read_table(out)
    assert len(table) == (3 + 4) * 4
    assert np.count_nonzero(table.numbers(("mass_kg",)) == 0.0) == 12
    assert call("check", out, "--robot", folder / "robot.yaml") == 0


def test_a_sheet_names_states_by_its_steps(folder: Path) -> None:
    """Every step of the sheet has a file of its own, named by its number."""
    config_file(folder, {"experiment.deflection_noise.shared_reference": True})
    xd.sheet(folder / "config.yaml", folder / "plan.csv").save(folder / "sheet", "mm,deg")
    sheet, true = xd.load(folder / "sheet" / "sheet.csv"), xd.load(folder / "true.csv")
    robot, generator = read_robot(folder / "robot.yaml"), np.random.default_rng(4)
    files = []
    for _, row in sheet.iterrows():
        planned = true.iloc[int(row["plan_row"]) - 1]
        pose = planned[list(POSE)].to_numpy(float)
        if row["mass_kg"] > 0:
            pose = pose + planned[list(DEFLECTION)].to_numpy(float)
        files.append(folder / f"{int(row['sequence']):03d}.txt")
        lines = listed(robot, pose, "x", generator).replace("Job::x::", "")
        files[-1].write_text(f"Name X[mm] Y[mm] Z[mm]\n{lines}", encoding="utf-8")
    found = xd.register(folder / "robot.yaml", folder / "sheet" / "sheet.csv", files, deviation=NOISE)
    order = [int(row) - 1 for row in sheet.loc[sheet["mass_kg"] > 0, "plan_row"]]
    errors = found.frame[list(DEFLECTION)].to_numpy() - true.iloc[order][list(DEFLECTION)].to_numpy()
    assert np.abs(errors / np.sqrt(np.diagonal(found.covariance, axis1=1, axis2=2))).max() < 4.0


def test_columns_of_the_plan_may_name_the_sets(folder: Path, tmp_path: Path) -> None:
    """Names of one's own, and the same deflections as by the names that say it themselves."""
    lists = []
    for name in ("unloaded", "loaded"):
        text = (folder / f"{name}.txt").read_text(encoding="utf-8")
        lists.append(tmp_path / f"{name}.txt")
        lists[-1].write_text(text.replace("unloaded-", "zero of ").replace("loaded-", "state "), encoding="utf-8")
    plan = xd.load(folder / "plan.csv")
    assert isinstance(plan, pd.DataFrame)
    plan["points"] = [f"state {number}" for number in plan["sequence"]]
    plan["reference_points"] = [f"zero of {number}" for number in plan["series"]]
    named = xd.register(folder / "robot.yaml", plan, lists, deviation=NOISE).frame
    plain = [folder / f"{name}.txt" for name in ("unloaded", "loaded")]
    expected = xd.register(folder / "robot.yaml", folder / "plan.csv", plain, deviation=NOISE).frame
    np.testing.assert_array_equal(named[list(DEFLECTION)], expected[list(DEFLECTION)])
    plan.loc[1, "points"] = "state 77"
    with pytest.raises(InputError, match="there is no set of points `state 77`") as error:
        xd.register(folder / "robot.yaml", plan, lists, deviation=NOISE)
    assert "row 3, column points" in error.value.where


@pytest.mark.parametrize(
    ("right", "wrong", "what"),
    [
        ("unloaded-2", "unloaded-9", "there are no unloaded points of series 2"),
        ("::loaded-4", "::loaded-14", "by the sets of points `unloaded-3`, `loaded-14`"),
    ],
)
def test_sets_that_belong_to_no_row_are_refused(
    right: str, wrong: str, what: str, folder: Path, tmp_path: Path, capsys: Printed
) -> None:
    lists = []
    for name in ("unloaded.txt", "loaded.txt"):
        text = (folder / name).read_text(encoding="utf-8")
        lists.append(yaml_file(tmp_path / name, text.replace(right, wrong)))
    out = tmp_path / "out.csv"
    assert what in refusal(capsys, "register", folder / "robot.yaml", folder / "plan.csv", *lists, "--out", out)
    assert not out.exists()
