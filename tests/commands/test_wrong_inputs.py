"""Every wrong input of the table: exit status 2, one message that says where and what, and nothing written."""

import shutil
from pathlib import Path

import pytest
import yaml

from expdesign.app.commands import main as entry
from tests.commands.calls import CONFIG, ROBOT, ROOT, Printed, call, model_file, refusal, refused, yaml_file
from tests.commands.wrong_inputs import WRONG, Wrong
from tests.design.problems import BIPOD

SEARCH = {"population": 4, "generations": 1, "polish": False}


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a right file of every kind."""
    folder = tmp_path_factory.mktemp("inputs")
    model_file(folder)
    shutil.copy(ROBOT, folder / "robot.yaml")
    for name in ("ur5.yaml", "ur5.urdf"):
        shutil.copy(ROBOT.parent / name, folder / name.replace("ur5.yaml", "arm.yaml"))
    content = yaml.safe_load(CONFIG.read_text(encoding="utf-8"))
    yaml_file(folder / "config.yaml", content | {"robot": "robot.yaml", "optimiser": SEARCH})
    robot = BIPOD["robot"] | {"limits": {"leg_length": [0.1, 2.0]}}
    yaml_file(folder / "bipod.yaml", BIPOD | {"robot": robot, "objectives": ["duir", "feir"]})
    yaml_file(folder / "bipod-plan.csv", "sequence,series,x_m,y_m,fx_N,fy_N\n1,1,-0.2,0.55,200,-900\n")
    vary = {"optimiser.seed": {"from": 1, "to": 10}}
    yaml_file(folder / "sweep.yaml", {"schema_version": 1, "config": "bipod.yaml", "vary": vary})
    return folder


def contents(folder: Path) -> dict[Path, bytes]:
    """Every file below a folder."""
    return {path: path.read_bytes() if path.is_file() else b"" for path in folder.rglob("*")}


def test_right_inputs_are_taken(inputs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the table spoils is right before."""
    monkeypatch.chdir(inputs)
    for name in ("robot", "arm", "config", "bipod", "sweep"):
        assert call("check", f"{name}.yaml") == 0
    assert call("check", "recordings.csv", "--robot", "robot.yaml") == 0
    assert call("evaluate", "bipod.yaml", "bipod-plan.csv") == 0
    assert call("evaluate", "config.yaml", "plan.csv") == 0


@pytest.mark.parametrize("wrong", WRONG, ids=str)
def test_wrong_inputs(
    wrong: Wrong, inputs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Printed
) -> None:
    folder = Path(shutil.copytree(inputs, tmp_path / "inputs"))
    monkeypatch.chdir(folder)
    wrong.change(folder)
    before = contents(folder)
    for command in wrong.calls:
        *notes, message = refusal(capsys, *command.split()).strip().splitlines()
        assert message.startswith("expdesign: ")
        assert [part for part in wrong.parts if part not in message] == [], message
        assert "?." not in message
        assert len(message) < 700
        assert not any("Traceback" in line for line in notes)
        assert contents(folder) == before


@pytest.mark.parametrize("where", ["taken", "taken/below"])
@pytest.mark.parametrize("command", ["run config.yaml", "diagnose robot.yaml recordings.csv"])
def test_a_file_where_the_folder_should_be(
    inputs: Path, capsys: Printed, command: str, where: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(inputs)
    (inputs / "taken").write_text("mine")
    for long_work in ("run.search", "diagnose.diagnose_recordings"):
        monkeypatch.setattr(f"expdesign.app.api.{long_work}", None)  # said before the work, not after it
    assert "is a file" in refused(capsys, *command.split(), "--out", where)
    assert (inputs / "taken").read_text() == "mine"


def test_a_place_where_no_folder_can_be_made_is_refused_before_the_work(capsys: Printed) -> None:
    place = Path("/proc/nothing-can-be-made-here")
    if not place.parent.is_dir():
        pytest.skip("no /proc here")
    assert "cannot be written" in refused(capsys, "montecarlo", "not-read.yaml", "not-read.csv", "--out", place)


def test_too_little_memory_is_a_message(capsys: Printed, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(**_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(entry, "app", full)
    assert "memory" in refused(capsys, "check", ROOT / "configs" / "bipod.yaml")
