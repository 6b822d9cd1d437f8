"""`expdesign diagnose`, and what is done with the model it writes."""

import json
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import expdesign as xd
from expdesign.app.api.callbacks import ProgressReport
from expdesign.chain.chain import Chain
from expdesign.chain.effects.legs.transmission import LegBacklash
from expdesign.chain.recordings.points import points_from_table
from expdesign.chain.row import row_data
from expdesign.diagnosis.stages import Stage
from expdesign.io.output import csv_text
from expdesign.io.table import parse_table
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.robots.robot_file import read_robot
from tests.commands.calls import ROOT, Printed, call

ROBOT = ROOT / "configs" / "robots" / "bipod.yaml"
GAP = 8e-6
VERDICTS = {"consistent", "explained", "unexplained"}


def recordings(folder: Path, gap: float = GAP) -> Path:
    """A bipod whose first leg has play, with noise."""
    generator = np.random.default_rng(2)
    here = read_robot(ROBOT)
    assert isinstance(here, ParallelRobot)
    poses = np.repeat(generator.uniform(-0.05, 0.05, (10, 2)), 4, axis=0)
    loads = generator.uniform(-1.0, 1.0, (40, 2)) * [400.0, 1000.0]
    frame = pd.DataFrame(np.hstack([poses, loads]), columns=["x_m", "y_m", "fx_N", "fy_N"])
    frame.insert(0, "sequence", np.arange(1, 41))
    frame.insert(1, "series", np.repeat(np.arange(1, 11), 4))
    chain = Chain(here, (LegBacklash.from_text(here, "leg 1", "middle"),))
    points = points_from_table(parse_table(csv_text(frame), "points"), here)
    exact = chain.predict(row_data(points, here), np.array([1.1, 0.9, gap]))
    frame[["dx_m", "dy_m"]] = exact + 5e-7 * generator.standard_normal(exact.shape)
    frame = frame.assign(sx_m=5e-7, sy_m=5e-7, remark="<i>windy</i>")
    path = folder / "recordings.csv"
    path.write_text(csv_text(frame), encoding="utf-8")
    return path


def record_of(out: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((out / "diagnosis.json").read_text(encoding="utf-8"))
    return content


@pytest.fixture(scope="module")
def diagnosed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with recordings and, in `out`, their diagnosis."""
    folder = tmp_path_factory.mktemp("diagnosed")
    assert call("diagnose", ROBOT, recordings(folder), "--out", folder / "out") == 0
    return folder


def check_record(record: dict[str, Any]) -> None:
    """What is said of any diagnosis; `tests/docs/test_file_formats.py` has the keys."""
    assert record["verdict"] in VERDICTS
    location = record["location"]
    assert (location is None) == (record["verdict"] == "consistent")
    if location is not None:
        assert location["axes"]
        assert set(location["axes"]) <= {"dx_m", "dy_m"}
        assert 0.0 <= location["share"] <= 1.0
    for effect in record["effects"]:
        assert 0.0 <= effect["probability"] <= 1.0
        assert all(len(interval) == 3 for interval in effect["parameters"].values())
    assert record["next_experiment"] is None or record["next_experiment"].endswith(".csv")


def test_it_writes_what_it_found(diagnosed: Path) -> None:
    record = record_of(diagnosed / "out")
    check_record(record)
    assert record["verdict"] == "explained"
    assert {"diagnosis.json", "model.yaml", "report.html"} <= {path.name for path in (diagnosed / "out").iterdir()}
    (effect,) = record["effects"]
    assert (effect["physics"], effect["component"]) == ("leg_backlash", "leg 1")
    estimate, low, high = effect["parameters"]["gap_m"]
    assert low < estimate < high
    assert abs(estimate - GAP) < 4.0 / 1.96 * (high - estimate)
    assert record["tests"]["p_value"] < 1e-3
    assert record["fit"]["noise_rms"] == 1.0
    assert record["fit"]["test_after"] < record["fit"]["test_before"]
    assert record["location"]["component"] == "leg 1"


def test_it_says_so_and_the_same_recordings_give_the_same_bytes(
    diagnosed: Path, tmp_path: Path, capsys: Printed
) -> None:
    assert call("diagnose", ROBOT, diagnosed / "recordings.csv", "--out", tmp_path / "again") == 0
    printed = capsys.readouterr()
    assert printed.out.splitlines()[-1] == str(tmp_path / "again" / "report.html")
    assert "Verdict: explained." in printed.out
    assert "Leg 1 has" in printed.out
    assert "µm of play" in printed.out
    for name in ("diagnosis.json", "model.yaml"):
        assert (tmp_path / "again" / name).read_bytes() == (diagnosed / "out" / name).read_bytes()


def test_the_model_predicts_what_the_recordings_show(diagnosed: Path, tmp_path: Path) -> None:
    """To the noise: the play included, which the base model would miss."""
    predicted = tmp_path / "predicted.csv"
    assert call("predict", diagnosed / "out" / "model.yaml", diagnosed / "recordings.csv", "--out", predicted) == 0
    measured, found = pd.read_csv(diagnosed / "recordings.csv"), pd.read_csv(predicted)
    residuals = (measured[["dx_m", "dy_m"]] - found[["dx_m", "dy_m"]]).to_numpy() / 5e-7
    record = record_of(diagnosed / "out")
    assert np.sqrt((residuals**2).mean()) == pytest.approx(record["fit"]["train_after"], rel=1e-6)
    assert (residuals**2).sum() == pytest.approx(record["tests"]["chi2_after"], rel=1e-6)
    assert (found[["sx_m", "sy_m"]] > 0.0).all(axis=None)


def test_recordings_of_the_base_robot_are_consistent(tmp_path: Path) -> None:
    assert call("diagnose", ROBOT, recordings(tmp_path, gap=0.0), "--out", tmp_path / "out") == 0
    record = record_of(tmp_path / "out")
    check_record(record)
    assert record["verdict"] == "consistent"
    assert record["effects"] == []
    assert record["location"] is None
    assert record["next_experiment"] is None
    assert "no missing physics" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("stage", ["looking for effect 2", "weighing alternatives"])
def test_what_is_interrupted_ends_with_the_best_model_so_far(
    stage: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Printed
) -> None:
    """Ctrl-C during a stage: the search has found the play by then."""
    shown = ProgressReport.update

    def pressed(self: ProgressReport, title: str, done: int, total: int, note: str) -> None:
        shown(self, title, done, total, note)
        assert f"stage {done} of at most {len(Stage)}" in note
        if note.endswith(stage):
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(ProgressReport, "update", pressed)
    assert call("diagnose", ROBOT, recordings(tmp_path), "--out", tmp_path / "out") == 0
    said = capsys.readouterr()
    assert "interrupted: the best model so far is written" in said.err
    sentence = f"Ended by hand during this step: {stage}."
    assert sentence in said.out
    assert sentence in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    record = record_of(tmp_path / "out")
    assert record["ended"] == stage
    assert [effect["physics"] for effect in record["effects"]] == ["leg_backlash"]
    check_record(record)
    assert call("check", tmp_path / "out" / "model.yaml") == 0
    with pytest.raises(KeyboardInterrupt):  # in Python only where it is asked for
        xd.diagnose(ROBOT, tmp_path / "recordings.csv", callback=lambda *stage: signal.raise_signal(signal.SIGINT))


def test_what_is_interrupted_before_there_is_a_model_writes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Printed
) -> None:
    monkeypatch.setattr(ProgressReport, "update", lambda *given: signal.raise_signal(signal.SIGINT))
    assert call("diagnose", ROBOT, recordings(tmp_path), "--out", tmp_path / "out") == 130
    assert "interrupted. Nothing was written." in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_recordings_that_fit_only_otherwise_end_with_status_3(tmp_path: Path) -> None:
    """What was diagnosed of readings with the wrong sign is no robot; all is written all the same."""
    frame = pd.read_csv(recordings(tmp_path, gap=0.0))
    frame["dy_m"] *= -1.0
    frame.to_csv(tmp_path / "turned.csv", index=False)
    assert call("diagnose", ROBOT, tmp_path / "turned.csv", "--out", tmp_path / "out") == 3
    assert record_of(tmp_path / "out")["verdict"] in {*VERDICTS, "modelled"}
