"""Wrong inputs of every sort: exit status 2, one message that says where, and nothing written."""

import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from expdesign.app.commands import main as entry
from tests.commands.calls import (
    CONFIG,
    PLAN,
    ROBOT,
    ROOT,
    call,
    model_file,
    plan_file,
    recordings_file,
    refusal,
    refused,
    yaml_file,
)
from tests.design.problems import changed


def loaded_config() -> Any:
    """The example configuration with its robot written out, and a small search."""
    content = yaml.safe_load(CONFIG.read_text())
    content["robot"] = str(ROBOT)
    content["optimiser"] = {"population": 4, "generations": 1, "polish": False}
    return content


def written(folder: Path, content: object, name: str = "input.yaml") -> Path:
    return yaml_file(folder / name, content)


@pytest.mark.parametrize(
    ("key", "value", "place"),
    [
        ("experiment.measurements", 10**9, "experiment.measurements"),
        ("experiment.measurements", 10**400, "experiment.measurements"),
        ("experiment.poses", {"bounds": {"x_m": 10**400}}, "experiment.poses.bounds.x_m"),
        ("experiment.poses", {"bounds": {"x_m": [-1e308, 1e308]}}, "experiment.poses.bounds.x_m"),
        ("experiment.poses", {"grid": {"x_m": [0, 1, 10**12]}}, "experiment.poses.grid.x_m"),
        ("experiment.poses", {"candidates": "y" * 300}, "experiment.poses.candidates"),
        ("experiment.poses", {"candidates": "."}, "experiment.poses.candidates"),
        ("experiment.load.mass_kg", 1e300, "experiment.load.mass_kg"),
        ("experiment.deflection_noise.std.dx_m", 1e-200, "experiment.deflection_noise.std.dx_m"),
        ("experiment.deflection_noise.std.dx_m", 1e300, "experiment.deflection_noise.std.dx_m"),
        ("experiment.load_error.1.std", 1e300, "experiment.load_error[1].std"),
        ("targets.0.tolerance.dz_m", 1e-200, "targets[0].tolerance.dz_m"),
        ("targets.0.tolerance.dz_m", 1e300, "targets[0].tolerance.dz_m"),
        ("targets.0.weight", 1e308, "targets[0].weight"),
        ("targets.0.gravity_m_s2", [0, 0, 1e300], "targets[0].gravity_m_s2[2]"),
        ("optimiser.population", 10**12, "optimiser.population"),
        ("robot", "y" * 300, "robot"),
        ("robot", ".", "robot"),
    ],
)
@pytest.mark.parametrize("command", ["check", "run"])
def test_extreme_entries_of_a_configuration(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str, key: str, value: object, place: str
) -> None:
    config = written(tmp_path, changed(loaded_config(), {key: value}))
    options = ["--out", tmp_path / "out"] if command == "run" else []
    message = refused(capsys, command, config, *options)
    assert f"{place}: " in message
    assert len(message) < 700
    assert [path.name for path in tmp_path.iterdir()] == ["input.yaml"]


@pytest.mark.parametrize("command", ["check", "run"])
@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"experiment.constraints": {"distinct_poses": 3}}, "3 different poses .* `experiment.poses` offers 2"),
        ({"experiment.constraints": {"distinct_masses": 2}}, "2 different masses .* offers 1"),
        ({"experiment.deflection_noise.std": {"dz_m": 1e-6}, "experiment.measurements": 5}, "at least 6 measurements"),
    ],
)
def test_what_no_plan_can_meet_is_said_with_what_there_is(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str, changes: dict[str, Any], said: str
) -> None:
    poses = {"candidates": [[0.0] * 6, [0.01, *[0.0] * 5], [0.0] * 6]}
    loads = {"experiment.poses": poses, "experiment.load.mass_kg": {"choices": [50, 50.0]}}
    config = written(tmp_path, changed(loaded_config(), loads | {"experiment.measurements": 6} | changes))
    options = ["--out", tmp_path / "out"] if command == "run" else []
    assert re.search(said, refused(capsys, command, config, *options))


def test_targets_without_a_load_leave_nothing_to_compensate(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    content = loaded_config()
    for target in content["targets"]:
        target["gravity_m_s2"] = [0.0, 0.0, 0.0]
    assert "targets: no target carries a load" in refused(capsys, "check", written(tmp_path, content))


def test_a_search_needs_something_to_choose(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    content = changed(loaded_config(), {"experiment.poses": {"bounds": {"x_m": 0.01}}})
    content["experiment"]["load"] = {"kind": "payload", "mass_kg": 20.0, "com_x_m": 0.1}
    config = written(tmp_path, content)
    assert call("check", config) == 0
    assert "nothing to choose" in refused(capsys, "run", config, "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()
    assert call("evaluate", config, plan_file(tmp_path)) == 0


@pytest.mark.parametrize("kind", ["[hexapod]", "{a: 1}", "3"])
def test_a_kind_that_is_no_text(tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str) -> None:
    assert "line 1, kind: unknown kind" in refused(capsys, "check", written(tmp_path, f"kind: {kind}\nname: a\n"))


def test_aliases_of_aliases_and_control_characters(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = ["a0: &a0 [0, 0, 0, 0, 0, 0, 0, 0, 0, 0]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 8)]
    assert "entries" in refused(capsys, "check", written(tmp_path, "\n".join(lines)))
    assert "not valid YAML" in refused(capsys, "check", written(tmp_path, "kind: hexapod\0\n"))


HEADER, *ROWS = PLAN.splitlines()


@pytest.mark.parametrize(
    ("column", "cell", "word"),
    [
        ("rx_rad", "30", "Check the unit"),
        ("x_m", "300", "Check the unit"),
        ("mass_kg", "1e300", "beyond any quantity"),
        ("com_x_m", "1e300", "beyond any quantity"),
        ("sequence", "1", "twice"),
        ("sequence", "1.5", "whole number"),
    ],
)
@pytest.mark.parametrize("command", ["evaluate", "simulate", "predict", "compensate"])
def test_cells_that_cannot_be_right(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str, column: str, cell: str, word: str
) -> None:
    first = model_file(tmp_path) if command in {"predict", "compensate"} else CONFIG
    cells = ROWS[2].split(",")
    cells[HEADER.split(",").index(column)] = cell
    table = written(tmp_path, "\n".join([HEADER, *ROWS[:2], ",".join(cells)]), "wrong.csv")
    out = tmp_path / "out.csv"
    message = refused(capsys, command, first, table, *([] if command == "evaluate" else ["--out", out]))
    assert f"wrong.csv, row 4, column {column}: " in message
    assert word in message
    assert not out.exists()


@pytest.mark.parametrize(("column", "cell", "word"), [("rz_rad", "1.5708", "singular"), ("series", "1", "command")])
def test_simulated_recordings_can_be_identified(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], column: str, cell: str, word: str
) -> None:
    cells = ROWS[2].split(",")
    cells[HEADER.split(",").index(column)] = cell
    plan = written(tmp_path, "\n".join([HEADER, *ROWS[:2], ",".join(cells)]), "wrong.csv")
    message = refused(capsys, "simulate", CONFIG, plan, "--out", tmp_path / "out.csv")
    assert "wrong.csv, row 4" in message
    assert word in message


def test_no_other_column_is_taken_for_the_missing_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = model_file(tmp_path)
    points = written(tmp_path, PLAN.replace("com_x_m", "colour"), "points.csv")
    message = refused(capsys, "predict", model, points, "--out", tmp_path / "out.csv")
    assert "column com_x_m: the column is missing. Add the column." in message


def recordings_with(folder: Path, **columns: str) -> Path:
    """Recordings in which whole columns are replaced or added."""
    lines = [line.split(",") for line in recordings_file(folder).read_text().splitlines()]
    for name, cell in columns.items():
        if name not in lines[0]:
            lines = [[*line, ""] for line in lines]
            lines[0][-1] = name
        index = lines[0].index(name)
        lines[1:] = [[*line[:index], cell, *line[index + 1 :]] for line in lines[1:]]
    return written(folder, "\n".join(",".join(line) for line in lines), "wrong.csv")


@pytest.mark.parametrize(
    ("columns", "word"),
    [
        ({"sx_m": "1e-200"}, "row 2, column sx_m"),
        ({"px_m": "0", "py_m": "0", "pz_m": "0", "marker": "a"}, "marker positions beside the deflections"),
        (dict.fromkeys(("dx_m", "dy_m", "dz_m", "drx_rad", "dry_rad", "drz_rad"), "0"), "every deflection is 0"),
    ],
)
@pytest.mark.parametrize("command", ["check", "identify", "diagnose", "next"])
def test_recordings_that_cannot_be_right(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str, columns: dict[str, str], word: str
) -> None:
    recordings = recordings_with(tmp_path, **columns)
    out = tmp_path / "out"
    arguments = {
        "check": [recordings, "--robot", ROBOT],
        "identify": [ROBOT, recordings, "--out", out],
        "diagnose": [ROBOT, recordings, "--out", out],
        "next": [CONFIG, recordings, "--out", out],
    }
    message = refused(capsys, command, *arguments[command])
    assert "wrong.csv" in message
    assert word in message
    assert not out.exists()


@pytest.mark.parametrize("command", ["check", "next"])
def test_columns_without_a_meaning_are_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    recordings = recordings_with(tmp_path, colour="red")
    capsys.readouterr()
    if command == "check":
        assert call("check", recordings, "--robot", ROBOT) == 0
    else:
        assert call("next", CONFIG, recordings, "--out", tmp_path / "next.csv") == 0
    assert "kept but not used: note, colour" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("key", "value", "place"),
    [
        ("covariance", [], "covariance"),
        ("covariance.5", [1.0], "covariance"),
        ("covariance.0.0", -1.0, "covariance"),
        ("covariance.0.0", float("nan"), "covariance[0][0]"),
        ("covariance.0.0", 1e308, "covariance[0][0]"),
        ("birge_ratio", 0.01, "birge_ratio"),
        ("compliance.leg 2", 2e-6, "compliance.leg 2"),
        ("relative_compliance.1", 10.0, "compliance.leg 2"),
        ("relative_compliance", [1.0], "relative_compliance"),
        ("robot.actuator_stiffness", [5.24e9] * 6, "compliance.leg 1"),
        ("calibrated.x_m", [0.01, -0.01], "calibrated.x_m"),
        ("covariance.0.1", 1.0, "covariance"),
        ("covariance.0.1", "a", "covariance[0][1]"),
        ("parameters", ["a"], "parameters"),
        ("robot", [1], "robot"),
        ("compliance.leg 1", 1e300, "compliance.leg 1"),
    ],
)
def test_models_that_cannot_be_right(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], key: str, value: object, place: str
) -> None:
    content = changed(yaml.safe_load(model_file(tmp_path).read_text()), {key: value})
    model = written(tmp_path, content)
    out = tmp_path / "out.csv"
    assert f", {place}: " in refused(capsys, "predict", model, plan_file(tmp_path), "--out", out)
    assert not out.exists()


@pytest.mark.parametrize("key", ["compliance", "relative_compliance"])
def test_a_robot_that_rises_under_its_load(tmp_path: Path, capsys: pytest.CaptureFixture[str], key: str) -> None:
    content = yaml.safe_load(model_file(tmp_path).read_text())
    content["compliance"] = {name: -value for name, value in content["compliance"].items()}
    content["relative_compliance"] = [-value for value in content["relative_compliance"]]
    if key == "compliance":
        del content["relative_compliance"]
    said = refused(capsys, "predict", written(tmp_path, content), plan_file(tmp_path), "--out", tmp_path / "out.csv")
    assert "compliance.leg 1: a negative compliance" in said


def test_a_small_compliance_may_be_negative_by_its_noise(tmp_path: Path) -> None:
    content = yaml.safe_load(model_file(tmp_path).read_text())
    del content["relative_compliance"]
    content["compliance"]["leg 1"] = -1e-9
    content["covariance"] = [[1e-18 * (row == column) for column in range(6)] for row in range(6)]
    model = written(tmp_path, content)
    assert call("predict", model, plan_file(tmp_path), "--out", tmp_path / "out.csv") == 0


def test_a_combination_that_would_be_more_than_certain(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    content = yaml.safe_load(model_file(tmp_path).read_text())
    rows = content["covariance"]
    rows[0][1] = rows[1][0] = 5.0 * (rows[0][0] * rows[1][1]) ** 0.5
    said = refused(capsys, "predict", written(tmp_path, content), plan_file(tmp_path), "--out", tmp_path / "out.csv")
    assert ", covariance: no covariance: some combination" in said


@pytest.mark.parametrize("where", ["taken", "taken/below"])
@pytest.mark.parametrize("command", ["run", "diagnose", "identify"])
def test_a_file_where_the_folder_should_be(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str, where: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "taken").write_text("mine")
    inputs = [CONFIG] if command == "run" else [ROBOT, recordings_file(tmp_path)]
    for long_work in ("run.search", "diagnose.diagnose_recordings", "identify.identify_recordings"):
        monkeypatch.setattr(f"expdesign.app.api.{long_work}", None)  # said before the work, not after it
    assert "is a file" in refused(capsys, command, *inputs, "--out", tmp_path / where)
    assert (tmp_path / "taken").read_text() == "mine"


def test_one_file_is_not_two_measurements(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recordings = recordings_file(tmp_path)
    out = tmp_path / "out"
    assert "given twice" in refused(capsys, "identify", ROBOT, recordings, recordings, "--out", out)
    assert not out.exists()


def test_too_little_memory_is_a_message(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    def full(**_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(entry, "app", full)
    assert "memory" in refused(capsys, "check", ROOT / "configs" / "bipod.yaml")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("run", "robot"), "this is a robot, not a run configuration"),
        (("evaluate", "plan", "config"), "this is a table, not a run configuration"),
        (("identify", "config", "plan", "--out", "out"), "this is a run configuration, not a robot"),
        (("compensate", "robot", "plan", "--out", "out"), "this is a robot, not an identified model"),
        (("predict", "config", "plan", "--out", "out"), "this is a run configuration, not a robot"),
        (("sweep", "robot", "--out", "out"), "this is a robot, not a sweep"),
        (("sweep", "config", "--out", "out"), "this is a run configuration, not a sweep"),
    ],
)
def test_a_file_in_the_place_of_another_is_called_by_its_name(
    arguments: tuple[str, ...], says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = {"robot": ROBOT, "config": CONFIG, "plan": plan_file(tmp_path), "out": tmp_path / "out"}
    assert says in refusal(capsys, *(files.get(argument, argument) for argument in arguments))


def test_a_column_that_is_nearly_known_is_compared_with_the_known_ones(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recordings = recordings_file(tmp_path)
    recordings.write_text(recordings.read_text(encoding="utf-8").replace("dx_m", "dx_mmm"), encoding="utf-8")
    assert call("check", recordings, "--robot", ROBOT) == 0
    assert "dx_mmm (is `dx_m` meant?)" in capsys.readouterr().err


def test_poses_in_millimetres_are_noticed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = CONFIG.read_text(encoding="utf-8").replace("robots/", f"{ROBOT.parent}/")
    config = tmp_path / "config.yaml"
    config.write_text(text.replace("x_m: [-0.03, 0.03]", "x_m: [-30, 30]"), encoding="utf-8")
    assert call("check", config) == 0
    assert "check their units (m, rad)" in capsys.readouterr().err
    config.write_text(text, encoding="utf-8")
    assert call("check", config) == 0
    assert "check their units" not in capsys.readouterr().err


def test_a_folder_in_the_place_of_an_output_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "this is a folder, not a file" in refusal(capsys, "simulate", CONFIG, plan_file(tmp_path), "--out", tmp_path)


def test_names_of_files_may_be_in_any_script(tmp_path: Path) -> None:
    folder = tmp_path / "Kalibrierung Ø – 校准 ✓"
    folder.mkdir()
    plan = plan_file(folder)
    assert call("simulate", CONFIG, plan, "--out", folder / "Aufnahmen ä.csv") == 0
    assert call("identify", ROBOT, folder / "Aufnahmen ä.csv", "--out", folder / "Ergebnis – 结果") == 0
    assert "Aufnahmen ä.csv" in (folder / "Ergebnis – 结果" / "report.html").read_text(encoding="utf-8")
