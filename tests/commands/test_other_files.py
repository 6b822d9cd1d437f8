"""A file of another kind in the place of one that is due is called by its name."""

from pathlib import Path

import pandas as pd
import pytest
import yaml

import expdesign as xd
from tests.commands.calls import CONFIG, ROBOT, ROOT, call, plan_file, recordings_file, refusal

ARM = ROOT / "configs/robots/ur5.yaml"


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("run.yaml", b"robot: x\ntargets:\n  - pose: [0, 0, 0, 0, 0, 0]\n", "this is a YAML file"),
        ("report.html", b"<!doctype html>\n<p>text</p>\n", "this is a page, not a table"),
        ("run.json", b'{"config": {}, "versions": {}}\n', "this is a record of results, not a table"),
        ("plan.xls", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1rest", "Save it as .xlsx"),
        ("plan.ods", b"PK\x03\x04rest", "Save it as .xlsx"),
    ],
)
def test_in_the_place_of_a_table(
    name: str, content: bytes, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).write_bytes(content)
    error = refusal(capsys, "evaluate", CONFIG, tmp_path / name)
    assert f"{name}: " in error
    assert said in error


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("report.html", "<!DOCTYPE html>\n<p>text</p>\n", "this is a page (HTML)"),
        ("run.json", '{"config": {"robot": "x"}, "versions": {}}\n', "this is a record of results"),
    ],
)
def test_in_the_place_of_yaml(
    name: str, content: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).write_text(content)
    plan = plan_file(tmp_path)
    for command in (("check", tmp_path / name), ("evaluate", tmp_path / name, plan), ("sweep", tmp_path / name)):
        options = ("--out", tmp_path / "out") if command[0] == "sweep" else ()
        assert said in refusal(capsys, *command, *options)


def test_a_robot_of_another_kind(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recordings = recordings_file(tmp_path)
    said = refusal(capsys, "identify", ARM, recordings, "--out", tmp_path / "out")
    assert "the rows have poses (x_m, y_m, z_m ...), and `UR5 arm` is commanded by q1_rad, q2_rad" in said
    assert "Is this the wrong robot file?" in said
    joints = pd.read_csv(recordings).rename(columns={"x_m": "q1_rad", "y_m": "q2_rad", "z_m": "q3_rad"})
    joints.drop(columns=["rx_rad", "ry_rad", "rz_rad"]).to_csv(tmp_path / "joints.csv", index=False)
    said = refusal(capsys, "identify", ROBOT, tmp_path / "joints.csv", "--out", tmp_path / "out")
    assert "the rows have joints (q1_rad, q2_rad, q3_rad ...), and `hexapod-h1` is commanded by x_m" in said


RING = """
name: stage
kind: hexapod
home: [0, 0, "500 mm"]
base: {radius_m: 400 mm, half_angle_deg: 10}
platform: {radius_m: 0.30, angles_deg: [0.1 rad, 75, 115, 195, 235, 355], height_m: -30 mm, yaw_deg: 0.5 rad}
actuator_stiffness: 1e7
"""


def test_units_in_rings(tmp_path: Path) -> None:
    """A text with its unit is the number in the unit of the key's name."""
    plain = RING.replace("400 mm", "0.4").replace("-30 mm", "-0.03").replace('"500 mm"', "0.5")
    plain = plain.replace("0.1 rad", "5.729577951308232").replace("0.5 rad", "28.64788975654116")
    for name, text in (("units", RING), ("plain", plain)):
        (tmp_path / f"{name}.yaml").write_text(text.replace("1e7", str([1e7] * 6)))
    robots = [xd.load(tmp_path / f"{name}.yaml") for name in ("units", "plain")]
    lengths = [robot.robot.lengths(robot.robot.reference_configuration()) for robot in robots]  # type: ignore[union-attr]
    assert abs(lengths[0] - lengths[1]).max() < 1e-15


@pytest.mark.parametrize("stiffness", [5.0, 1e15])
def test_a_stiffness_that_cannot_be(stiffness: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    content = yaml.safe_load(ROBOT.read_text(encoding="utf-8")) | {"actuator_stiffness": [stiffness] * 6}
    (tmp_path / "robot.yaml").write_text(yaml.safe_dump(content))
    assert call("check", tmp_path / "robot.yaml") == 2
    printed = capsys.readouterr()
    assert f"no machine has an actuator stiffness of {stiffness:.3g} N/m" in printed.err
    assert "usable" not in printed.out
