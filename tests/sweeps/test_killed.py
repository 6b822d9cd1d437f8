"""Proofs with real processes: a worker, the scheduler, or the sweep itself is killed, and no finished run is lost."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest

from expdesign.app.sweeps.store import RUNS, TIMES
from tests.sweeps.small import contents, sweep_file

COMMAND = (sys.executable, "-m", "expdesign", "sweep")
VARY = {"experiment.measurements": [1, 2, 3], "optimiser.seed": {"from": 1, "to": 4}}
PATIENCE = 300.0
"""s until a step counts as stuck."""

pytestmark = pytest.mark.slow


def on_cluster(sweep: Path, folder: Path, kill_after: int) -> None:
    """The sweep on two workers, of which one is killed (`kill -9`) when `kill_after` runs are finished."""
    from distributed import Client, LocalCluster  # noqa: PLC0415 (an extra)

    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        address = str(cluster.scheduler_address)
        command = [*COMMAND, str(sweep), "--out", str(folder), "--cluster", address]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
            while process.poll() is None and finished_runs(folder) < kill_after:
                time.sleep(0.05)
            victim = next(iter(client.run(os.getpid).values()))
            assert process.poll() is None, "the sweep ended before a worker could be killed"
            os.kill(victim, signal.SIGKILL)
            if process.wait() != 0:
                raise RuntimeError(f"the sweep ended with status {process.returncode}")


def finished_runs(folder: Path) -> int:
    """How many runs lie in the folder of a sweep."""
    return sum(not path.name.startswith(".") for path in (folder / RUNS).iterdir()) if (folder / RUNS).is_dir() else 0


@pytest.fixture(scope="module")
def serial(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, bytes]]:
    """A sweep, and its results when it is done one run after another."""
    folder = tmp_path_factory.mktemp("sweep")
    file, out = sweep_file(folder, vary=VARY), folder / "out"
    subprocess.run([*COMMAND, str(file), "--out", str(out), "--workers", "1"], check=True, stdout=subprocess.DEVNULL)
    return file, contents(out)


def wait_for(folder: Path, runs: int, process: "subprocess.Popen[str]") -> None:
    """Until so many runs are finished."""
    until = time.monotonic() + PATIENCE
    while finished_runs(folder) < runs:
        assert process.poll() is None, "the sweep ended too early"
        assert time.monotonic() < until, "the sweep is stuck"
        time.sleep(0.02)


@pytest.mark.filterwarnings("ignore")  # of Dask and its event loop
def test_a_killed_worker_of_a_cluster(serial: tuple[Path, dict[str, bytes]], tmp_path: Path) -> None:
    out = tmp_path / "out"
    on_cluster(serial[0], out, kill_after=4)
    assert len(pd.read_csv(out / TIMES)) == 12
    assert contents(out) == serial[1]


def test_a_killed_scheduler(serial: tuple[Path, dict[str, bytes]], tmp_path: Path) -> None:
    out, contact = tmp_path / "out", tmp_path / "scheduler.json"
    run = [sys.executable, "-m", "distributed.cli"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    options = ["--port", "0", "--no-dashboard", "--scheduler-file", str(contact)]
    with subprocess.Popen([*run[:2], f"{run[2]}.dask_scheduler", *options], **quiet) as scheduler:  # type: ignore[call-overload]
        command = [*run[:2], f"{run[2]}.dask_worker", "--scheduler-file", str(contact), "--nthreads", "1", "--no-nanny"]
        with subprocess.Popen([*command, "--no-dashboard"], **quiet) as worker:  # type: ignore[call-overload]
            until = time.monotonic() + PATIENCE
            while not contact.exists():
                assert time.monotonic() < until
                time.sleep(0.1)
            time.sleep(1.0)
            address = contact.read_text().split('"address": "')[1].split('"')[0]
            sweep = [*COMMAND, str(serial[0]), "--out", str(out), "--cluster", address]
            with subprocess.Popen(sweep, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
                wait_for(out, 3, process)
                scheduler.kill()
                _, said = process.communicate(timeout=PATIENCE)
                assert process.returncode == 2
            worker.kill()
    last = said.strip().splitlines()[-1]
    assert "connection to the scheduler was lost" in last
    assert "of 12 runs are finished and kept" in last
    kept = finished_runs(out)
    assert 3 <= kept < 12
    subprocess.run([*COMMAND, str(serial[0]), "--out", str(out), "--workers", "2"], check=True)
    assert contents(out) == serial[1]


@pytest.mark.parametrize("kill", [signal.SIGKILL, signal.SIGINT])
def test_a_killed_sweep(serial: tuple[Path, dict[str, bytes]], tmp_path: Path, kill: signal.Signals) -> None:
    out = tmp_path / "out"
    command = [*COMMAND, str(serial[0]), "--out", str(out), "--workers", "2"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True) as process:
        wait_for(out, 3, process)
        os.kill(process.pid, kill)
        _, said = process.communicate(timeout=PATIENCE)  # its workers hold standard error: this waits for them too
        assert process.returncode == (-9 if kill == signal.SIGKILL else 130)
    assert "Traceback" not in said
    assert 3 <= finished_runs(out) < 12
    again = subprocess.run(command, check=True, capture_output=True, text=True)
    assert "were done before" in again.stderr or "12/12" in again.stderr
    assert contents(out) == serial[1]
