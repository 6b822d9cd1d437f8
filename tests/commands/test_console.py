"""Progress names the stage and states no time that is not known; an interrupted command says what it wrote."""

import re
from pathlib import Path

import pytest

import expdesign as xd
from expdesign.app.api.callbacks import remaining, stages
from expdesign.counted import counted
from tests.commands.calls import CONFIG, Printed, call, plan_file
from tests.commands.test_diagnose import ROBOT as BIPOD
from tests.commands.test_diagnose import recordings


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """A clock that is set by hand."""
    now = [0.0]
    monkeypatch.setattr("expdesign.app.api.callbacks.time.monotonic", lambda: now[0])
    return now


@pytest.mark.parametrize(
    ("elapsed", "done", "total", "text"),
    [
        (10.0, 0, 40, ""),
        (10.0, 3, 40, ""),  # less than a tenth
        (10.0, 10, 40, "(30 s left)"),
        (600.0, 10, 40, "(30 min left)"),
        (6000.0, 10, 40, "(5 h 0 min left)"),
        (10.0, 40, 40, ""),
    ],
)
def test_time_is_stated_where_it_is_known(elapsed: float, done: int, total: int, text: str) -> None:
    assert remaining(elapsed, done, total) == text


def test_stages_are_counted(clock: list[float], capsys: Printed) -> None:
    with stages("searching", "bounding") as report:
        for title, done, total in (
            ("searching", 10, 40),
            ("searching", 20, 40),
            ("bounding", 0, 2),
            ("bounding", 2, 2),
        ):
            report(title, done, total, "front 3")
            clock[0] += 10.0
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "searching (stage 1 of 2): 20/40 front 3"  # generations do not cost alike: no time
    assert lines[-1] == "bounding (stage 2 of 2): 2/2 front 3"


def test_steps_that_cost_alike(clock: list[float], capsys: Printed) -> None:
    with stages("sweeping") as report:
        for done in (10, 11, 20):  # ten were done before: this command does one, then nine more, in 10 s each
            report("sweeping", done, 30, "")
            clock[0] += 10.0
    assert capsys.readouterr().err.splitlines() == ["sweeping: 11/30", "sweeping: 20/30 (20 s left)"]


def test_a_number_of_steps_that_is_not_known(clock: list[float], capsys: Printed) -> None:
    with stages("diagnosing") as callback:
        callback("diagnosing", 1, 0, "fitting")
        clock[0] += 10.0
        callback("diagnosing", 4, 0, "refitting")
    assert capsys.readouterr().err == "diagnosing: refitting\n"


def test_interrupted_after_something_was_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Printed
) -> None:
    def stop(text: str) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("expdesign.app.commands.call.note", stop)
    out = tmp_path / "rows.csv"
    assert call("simulate", CONFIG, plan_file(tmp_path), "--out", out) == 130
    assert capsys.readouterr().err.endswith(f"expdesign: interrupted. Complete and kept: {out}.\n")


def test_numbers_with_their_nouns(tmp_path: Path, capsys: Printed) -> None:
    assert (counted(1, "axis", "axes"), counted(2, "axis", "axes"), counted(2, "row")) == ("1 axis", "2 axes", "2 rows")
    plan = plan_file(tmp_path)
    plan.write_text("\n".join(plan.read_text().splitlines()[:2]) + "\n")
    assert call("simulate", CONFIG, plan, "--out", tmp_path / "rows.csv") == 0
    assert call("check", tmp_path / "rows.csv") == 0
    printed = capsys.readouterr()
    assert "1 row simulated" in printed.err
    assert not re.search(r"\b1 (?!series)\w+s\b", printed.out), printed.out


def test_progress_and_callback_are_told_the_same(tmp_path: Path, clock: list[float], capsys: Printed) -> None:
    told: list[str] = []

    def callback(stage: str, done: int, total: int, note: str) -> None:
        told.append(note)
        clock[0] += 10.0

    xd.diagnose(BIPOD, recordings(tmp_path), callback=callback)
    assert capsys.readouterr().err == ""
    silently, told = told, []
    xd.diagnose(BIPOD, tmp_path / "recordings.csv", callback=callback, progress=True)
    assert told == silently
    assert told[-1] in capsys.readouterr().err
