"""How a file is written: what can be read with certainty is read and said, anything else refused with what is meant."""

import logging
from pathlib import Path

import numpy as np
import pytest
import yaml

import expdesign as xd
from expdesign.errors import InputError
from tests.commands.calls import CONFIG, Printed, call, plan_file
from tests.commands.test_register import folder as folder  # noqa: PLC0414 (a fixture)
from tests.commands.test_register import robot_file
from tests.plausibility.mistaken_files import POINTS, READ_AS, REFUSED, WORKBOOKS, YAML
from tests.plausibility.sound import CONFIGS, content_of, recordings_of
from tests.recordings.test_registered_deflections import MARKERS

Log = pytest.LogCaptureFixture


@pytest.fixture(scope="module")
def sound() -> str:
    return recordings_of(content_of("hexapod-h1"), 5, rows=8).to_csv(index=False)


def stiffness(text: str | bytes, path: Path) -> np.ndarray:
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return xd.identify(CONFIGS / "robots" / "hexapod-h1.yaml", path).stiffness["estimate"].to_numpy()


@pytest.mark.parametrize("name", READ_AS)
def test_what_can_mean_one_thing_only_is_read_so(name: str, sound: str, tmp_path: Path, caplog: Log) -> None:
    change, says = READ_AS[name]
    with caplog.at_level(logging.INFO, "expdesign"):
        found = stiffness(change(sound), tmp_path / "changed.csv")
    assert says in caplog.text
    np.testing.assert_allclose(found, stiffness(sound, tmp_path / "sound.csv"), rtol=1e-9)


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_nearly_known_is_refused_with_what_is_meant(name: str, sound: str, tmp_path: Path) -> None:
    change, says = REFUSED[name]
    with pytest.raises(InputError) as error:
        stiffness(change(sound), tmp_path / "changed.csv")
    assert says in error.value.message


@pytest.mark.parametrize("name", WORKBOOKS)
def test_workbooks(name: str, sound: str, tmp_path: Path, caplog: Log, capsys: Printed) -> None:
    change, says = WORKBOOKS[name]
    (tmp_path / "changed.xlsx").write_bytes(change(sound))
    with caplog.at_level(logging.INFO, "expdesign"):
        call("check", tmp_path / "changed.xlsx")
    assert says in capsys.readouterr().err + caplog.text


@pytest.mark.parametrize("name", YAML)
def test_decimal_commas_in_a_configuration(name: str, tmp_path: Path) -> None:
    old, new, says = YAML[name]
    text = yaml.safe_dump(content_of("hexapod-h1"), default_flow_style=None, width=1000)
    robot = "actuator_stiffness: [5.24e6, 5.24e6, 5.24e6, 5.24e6, 5.24e6, 5.24e6]"
    text = text.replace("actuator_stiffness: [5240000.0, 5240000.0, 5240000.0, 5240000.0, 5240000.0, 5240000.0]", robot)
    assert old in text
    (tmp_path / "config.yaml").write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError) as error:
        xd.check(tmp_path / "config.yaml")
    assert says in error.value.message


@pytest.mark.parametrize("name", POINTS)
def test_lists_of_points(name: str, folder: Path, tmp_path: Path, capsys: Printed) -> None:
    file, change, says = POINTS[name]
    for each in ("unloaded.txt", "loaded.txt"):
        text = (folder / each).read_text(encoding="utf-8")
        (tmp_path / each).write_text(change(text) if file in (each, "both") else text, encoding="utf-8")
    lists = (tmp_path / "unloaded.txt", tmp_path / "loaded.txt")
    call("register", folder / "robot.yaml", folder / "plan.csv", *lists, "--out", tmp_path / "out.csv")
    assert says in capsys.readouterr().err


def test_a_marker_that_is_drawn_elsewhere_and_the_fit_to_the_others(
    folder: Path, tmp_path: Path, capsys: Printed
) -> None:
    lists = (folder / "unloaded.txt", folder / "loaded.txt")
    assert call("register", folder / "robot.yaml", folder / "plan.csv", *lists, "--out", tmp_path / "out.csv") == 0
    said = "".join(capsys.readouterr())
    assert "points fit the robot's `markers` to " in said
    assert "warning" not in said
    for far in (0.004, 0.03):
        places = {name: place.tolist() for name, place in MARKERS.items()}
        places["c"] = (MARKERS["c"] + [0.0, 0.0, far]).tolist()
        wrong = robot_file(tmp_path, markers=places)
        out = tmp_path / f"marker-{far}.csv"
        assert call("register", wrong, folder / "plan.csv", *lists, "--out", out) == 0
        says = f"marker c lies {1e3 * far:.0f} mm from where the robot file has it, and the others fit"
        assert says in "".join(capsys.readouterr())


def test_a_standard_deviation_without_its_unit(folder: Path, tmp_path: Path, capsys: Printed) -> None:
    lists = (folder / "unloaded.txt", folder / "loaded.txt")
    arguments = (folder / "robot.yaml", folder / "plan.csv", *lists, "--out", tmp_path / "out.csv", "--std", "3e-6")
    assert call("register", *arguments) == 2
    assert "--std: `3e-6` has no unit. Write e.g. `3 um`, if metres are meant." in capsys.readouterr().err


def test_a_missing_row_is_said_in_the_words_of_the_list(folder: Path, tmp_path: Path, capsys: Printed) -> None:
    """A sheet has its unloaded rows, and its sets are named by rows."""
    plan_file(tmp_path)
    assert call("sheet", CONFIG, tmp_path / "plan.csv", "--out", tmp_path / "sheet") == 0
    sheet = xd.load(tmp_path / "sheet" / "sheet.csv")
    numbers = sheet["sequence"].tolist()
    points = (folder / "loaded.txt").read_text(encoding="utf-8").splitlines()
    first = [line.split("::")[2] for line in points if "loaded-1" in line]
    text = "// Units: mm\n" + "".join(f"row-{number}::{line}\n" for number in numbers[1:] for line in first)
    (tmp_path / "points.txt").write_text(text, encoding="utf-8")
    robot = robot_file(tmp_path)
    arguments = (tmp_path / "sheet" / "sheet.csv", tmp_path / "points.txt", "--out", tmp_path / "out.csv")
    assert call("register", robot, *arguments) == 2
    assert f"there are no points of row {numbers[0]}" in (said := capsys.readouterr().err)
    assert f"Add the set `row-{numbers[0]}`" in said


def test_a_blank_separated_list_with_decimal_commas(folder: Path, tmp_path: Path) -> None:
    lists = []
    for each in ("unloaded.txt", "loaded.txt"):
        (tmp_path / each).write_text((folder / each).read_text(encoding="utf-8").replace(".", ","), encoding="utf-8")
        lists.append(tmp_path / each)
    found = xd.register(folder / "robot.yaml", folder / "plan.csv", lists).frame
    same = xd.register(
        folder / "robot.yaml", folder / "plan.csv", [folder / "unloaded.txt", folder / "loaded.txt"]
    ).frame
    assert found.equals(same)


@pytest.mark.parametrize(("angle", "asked"), [(2.0944, False), (-3.1415, False), (5.0, True)])
def test_an_instrument_may_be_turned_by_any_angle_up_to_half_a_turn(
    angle: float, asked: bool, tmp_path: Path, caplog: Log
) -> None:
    content = yaml.safe_load((CONFIGS / "robots" / "hexapod-h1.yaml").read_text(encoding="utf-8"))
    path = tmp_path / "robot.yaml"
    path.write_text(yaml.safe_dump(content | {"instrument": [1.5, -2.2, 0.4, 0.0, 0.0, angle]}), encoding="utf-8")
    xd.check(path)
    assert ("Is it in degrees?" in caplog.text) is asked
