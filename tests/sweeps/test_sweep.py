"""A sweep keeps what is finished whatever happens, goes on with the same command, and its bytes do not tell where."""

import errno
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import Executor, Future
from functools import partial
from pathlib import Path
from threading import Timer
from typing import Any

import pandas as pd
import pytest

import expdesign as xd
from expdesign.app.parallel import Executors, Processes, WorkersError, results
from expdesign.app.sweeps.store import sole_writer
from expdesign.errors import InputError
from tests.commands.calls import Printed, call
from tests.sweeps.small import Sent, contents, sweep_file

VARY = {"experiment.measurements": [1, 2], "optimiser.seed": [1, 2]}


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A sweep file, and the folder of the sweep done one run after another."""
    folder = tmp_path_factory.mktemp("sweep")
    file = sweep_file(folder, vary=VARY)
    assert call("sweep", file, "--out", folder / "out", "--workers", 1) == 0
    return file, folder / "out"


class Interrupted(Executor):
    """Ends after some tasks."""

    def __init__(self, count: int, error: BaseException) -> None:
        self.count, self.error = count, error

    def submit(self, work: Callable[..., Any], /, *arguments: Any, **options: Any) -> "Future[Any]":
        found: Future[Any] = Future()
        if self.count > 0:
            found.set_result(work(*arguments))
        elif self.count == 0:
            Timer(1.0, found.set_exception, [self.error]).start()
        self.count -= 1
        return found


def test_each_run_has_a_folder_with_the_files_of_a_run(done: tuple[Path, Path]) -> None:
    table = pd.read_csv(done[1] / "sweep.csv")
    assert list(table["run"]) == [1, 2, 3, 4]
    assert set(table["status"]) == {"finished"}
    for row in table.itertuples():
        folder = done[1] / str(row.folder)
        names = {
            "computed_by.json",
            "config.yaml",
            "pareto.csv",
            "plan-checked.csv",
            "plan.csv",
            "plans.csv",
            "run.json",
        }
        assert {path.name for path in folder.iterdir()} == names
        evaluation = xd.evaluate(folder / "config.yaml", folder / "plan.csv").record
        assert evaluation["total"] == pytest.approx(row.total, rel=1e-12)
    totals = table.groupby("experiment.measurements")["total"].min()
    assert totals[2] < totals[1]


def test_processes_give_the_bytes_of_one_process(done: tuple[Path, Path], tmp_path: Path) -> None:
    assert call("sweep", done[0], "--out", tmp_path / "out", "--workers", 2) == 0
    assert contents(tmp_path / "out") == contents(done[1])


@pytest.mark.parametrize("error", [KeyboardInterrupt(), WorkersError("gone")])
def test_an_interrupted_sweep_goes_on(done: tuple[Path, Path], tmp_path: Path, error: BaseException) -> None:
    out = tmp_path / "out"
    with pytest.raises(type(error)) as caught:
        xd.sweep(done[0], out, executors=partial(Interrupted, 2, error))
    if isinstance(error, WorkersError):
        assert "2 of 4 runs are finished and kept" in str(caught.value)
    kept = {name: data for name, data in contents(out).items() if name.startswith("runs")}
    expected = contents(done[1])
    assert len(kept) == 2 * 7
    assert all(expected[name] == data for name, data in kept.items())
    before = Sent.given
    xd.sweep(done[0], out, executors=Sent)
    assert Sent.given - before == 2
    assert contents(out) == expected


def test_a_longer_sweep_does_only_what_is_new(done: tuple[Path, Path], tmp_path: Path) -> None:
    file = sweep_file(tmp_path, vary=VARY | {"optimiser.seed": [0, 1, 2]})
    shutil.copytree(done[1], tmp_path / "out")
    before = Sent.given
    table = xd.sweep(file, tmp_path / "out", executors=Sent).table
    assert Sent.given - before == 2
    assert len(table) == 6


def test_a_full_disk_costs_no_finished_run(
    done: tuple[Path, Path], tmp_path: Path, capsys: Printed, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    runs = 0
    replace = os.replace

    def full(source: Any, target: Any) -> None:
        nonlocal runs
        runs += Path(target).parent.name == "runs"
        if runs > 1:  # when the second run takes its place
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        replace(source, target)

    monkeypatch.setattr("expdesign.io.output.os.replace", full)
    assert call("sweep", done[0], "--out", out, "--workers", 1) == 2
    error = capsys.readouterr().err.strip().splitlines()[-1]
    assert "No space left" in error
    assert "1 of 4 runs are finished and kept" in error
    assert len(list((out / "runs").iterdir())) == 1  # and nothing half-written beside it
    monkeypatch.setattr("expdesign.io.output.os.replace", replace)
    assert call("sweep", done[0], "--out", out, "--workers", 1) == 0
    assert contents(out) == contents(done[1])


def test_a_run_that_has_no_result_says_why_and_stops_no_other(tmp_path: Path) -> None:
    """Without a load nothing is identified; that is a result, and is not tried again."""
    file = sweep_file(tmp_path, vary={"experiment.load.fy_N": [0, -1000]})
    table = xd.sweep(file, tmp_path / "out").table
    assert list(table["status"]) == ["failed", "finished"]
    assert "stiffnesses" in table["message"].iloc[0] or "identif" in table["message"].iloc[0]
    before = Sent.given
    assert xd.sweep(file, tmp_path / "out", executors=Sent).failed == 1
    assert Sent.given == before


def test_what_a_killed_sweep_left_half_written_is_removed(done: tuple[Path, Path], tmp_path: Path) -> None:
    out = tmp_path / "out"
    shutil.copytree(done[1], out)
    identity = next(path.name for path in (out / "runs").iterdir())
    shutil.rmtree(out / "runs" / identity)
    (out / "runs" / f".{identity}-abc").mkdir()
    (out / "runs" / f".{identity}-abc" / "run.json").write_text("{")
    xd.sweep(done[0], out, force=True)
    assert contents(out) == contents(done[1])


def test_only_one_sweep_writes_a_folder(done: tuple[Path, Path], tmp_path: Path) -> None:
    with sole_writer(tmp_path / "out"), pytest.raises(InputError, match="another sweep"):
        xd.sweep(done[0], tmp_path / "out")


def test_damaged_results_are_named(done: tuple[Path, Path], tmp_path: Path) -> None:
    run = next((done[1] / "runs").iterdir())
    folder = tmp_path / "out" / "runs" / run.name
    folder.mkdir(parents=True)
    (folder / "run.json").write_text("{")
    with pytest.raises(InputError, match=run.name):
        xd.sweep(done[0], tmp_path / "out")


# Executors themselves, on tasks of their own.
def squared(number: int) -> int:
    return number**2


def dies_once(task: tuple[str, int]) -> int:
    """Ends its process the first time that it meets the number 3, as `kill -9` would."""
    marker, number = Path(task[0]), task[1]
    if number == 3 and not marker.exists():
        marker.touch()
        os._exit(9)
    time.sleep(0.05)
    return number**2


def always_dies(number: int) -> int:
    if number == 3:
        os._exit(9)
    return number


@pytest.mark.parametrize("executors", [None, Sent])
def test_every_task_is_done_once(executors: Executors | None) -> None:
    assert dict(results(squared, range(7), executors)) == {number: number**2 for number in range(7)}
    assert list(results(squared, [], executors)) == []


def test_a_killed_worker_loses_nothing(tmp_path: Path) -> None:
    tasks = [(str(tmp_path / "marker"), number) for number in range(8)]
    found = list(results(dies_once, tasks, partial(Processes, 2)))
    assert (tmp_path / "marker").exists()
    assert sorted(found) == [(number, number**2) for number in range(8)]


def test_work_that_always_ends_its_process_is_given_up() -> None:
    with pytest.raises(WorkersError, match="3 times"):
        list(results(always_dies, range(6), partial(Processes, 1)))


def test_without_locks_of_the_system(tmp_path: Path) -> None:
    """Windows has no `fcntl`: sweeps are imported and done all the same."""
    file = sweep_file(tmp_path, vary={"experiment.measurements": [1]})
    code = "import sys; sys.modules['fcntl'] = None\nimport expdesign as xd\nprint(xd.sweep(*sys.argv[1:]).summary)"
    command = [sys.executable, "-c", code, str(file), str(tmp_path / "out")]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.startswith("1 run in")


def leave_a_mark(task: tuple[str, int]) -> int:
    folder, number = task
    with (Path(folder) / f"{number}.txt").open("a", encoding="utf-8") as stream:
        stream.write("done\n")
    return number


def test_a_slow_reader_of_results_makes_no_work_twice(tmp_path: Path) -> None:
    """While a result is written others arrive, which once was taken for the end of their worker."""
    tasks = [(str(tmp_path), number) for number in range(12)]
    found = []
    for index, result in results(leave_a_mark, tasks, partial(Processes, 2)):
        time.sleep(0.05)
        found.append((index, result))
    assert sorted(found) == [(number, number) for number in range(12)]
    assert [(tmp_path / f"{number}.txt").read_text() for number in range(12)] == ["done\n"] * 12
