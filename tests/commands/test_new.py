"""`new` writes files that run as they are, and overwrites nothing."""

from pathlib import Path

import pandas as pd
import pytest
import yaml

from expdesign.app.templates import kinds
from tests.commands.calls import Printed, call

CONFIGURATIONS = [kind for kind, files in kinds().items() if "config.yaml" in {file.name for file in files}]


@pytest.mark.parametrize("kind", CONFIGURATIONS)
def test_what_is_written_runs_as_it_is(kind: str, tmp_path: Path, capsys: Printed) -> None:
    folder = tmp_path / "mine"
    assert call("new", kind, "--out", folder) == 0
    assert capsys.readouterr().out.split() == [str(folder / file.name) for file in kinds()[kind]]
    config = folder / "config.yaml"
    assert sum(line.count("#") for line in config.read_text().splitlines()) > 8  # commented
    assert call("check", config) == 0
    assert call("run", config, "--out", folder / "results", "--seconds", 0) == 0
    planned = yaml.safe_load(config.read_text())["experiment"]["measurements"]
    assert len(pd.read_csv(folder / "results" / "plan.csv")) == planned


def test_a_sweep_of_what_was_written(tmp_path: Path, capsys: Printed) -> None:
    assert call("new", "bipod", "--out", tmp_path) == 0
    assert call("new", "sweep", "--out", tmp_path) == 0
    capsys.readouterr()
    assert call("check", tmp_path / "sweep.yaml") == 0
    assert "sweep of 9 runs over targets[0].weight" in capsys.readouterr().out


def test_a_sweep_alone_comes_with_what_it_points_to(tmp_path: Path, capsys: Printed) -> None:
    assert call("new", "sweep", "--out", tmp_path / "my sweep") == 0
    said = capsys.readouterr().err
    assert f"next: expdesign sweep '{tmp_path / 'my sweep' / 'sweep.yaml'}'" in said
    content = yaml.safe_load((tmp_path / "my sweep" / "sweep.yaml").read_text())
    (tmp_path / "my sweep" / "sweep.yaml").write_text(
        yaml.safe_dump(content | {"vary": {"optimiser.seed": [1]}, "cases": [{"optimiser.generations": 1}]})
    )
    assert call("sweep", tmp_path / "my sweep" / "sweep.yaml", "--out", tmp_path / "out", "--workers", 1) == 0
    assert set(pd.read_csv(tmp_path / "out" / "sweep.csv")["status"]) == {"finished"}
    assert (tmp_path / "my sweep" / "robot.yaml").is_file()


def test_files_are_written_here_where_no_folder_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert call("new", "bipod") == 0
    assert (tmp_path / "config.yaml").is_file()
