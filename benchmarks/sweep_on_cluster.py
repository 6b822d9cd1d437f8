"""A sweep on a local Dask cluster of which one worker is killed in the middle, beside the same sweep run serially.

    python -m benchmarks.sweep_on_cluster configs/sweep-bipod.yaml --out results/sweep

Shown: all runs finish, their bytes are those of the serial sweep, and the time of the sweep is near the runs' own time
divided by the workers.
"""

import argparse
import csv
import hashlib
import os
import signal
import subprocess
import sys
import tempfile
import textwrap
import time
from dataclasses import dataclass
from pathlib import Path

from expdesign.app.sweeps.store import RUNS, TABLE, TIMES
from expdesign.io.output import write_file
from expdesign.io.written import RECORD

COMMAND = (sys.executable, "-m", "expdesign", "sweep")


@dataclass(frozen=True)
class Timed:
    """A finished sweep: time of the whole (s), times of its runs (s), and the digest of everything but the times."""

    wall: float
    runs: list[float]
    digest: str

    def ratio(self, workers: int) -> float:
        """Time of the whole as a multiple of the runs' own time divided by the workers."""
        return self.wall / (sum(self.runs) / workers)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("sweep", type=Path)
    parser.add_argument("--out", type=Path, default=Path("results/sweep"))
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        serial = timed(arguments.sweep, folder / "serial", "--workers", "1")
        processes = timed(arguments.sweep, folder / "processes", "--workers", "2")
        whole = on_cluster(arguments.sweep, folder / "whole", None)
        killed = on_cluster(arguments.sweep, folder / "killed", len(serial.runs) // 3)
        table = (folder / "killed" / TABLE).read_text(encoding="utf-8")
    found = {
        "one process": (serial, 1),
        "two processes": (processes, 2),
        "cluster of two workers": (whole, 2),
        "cluster of two workers, one killed after a third of the runs": (killed, 2),
    }
    write_file(arguments.out / TABLE, table)
    write_file(arguments.out / "README.md", text_of(found, arguments))
    print(text_of(found, arguments))


def timed(sweep: Path, folder: Path, *options: str) -> Timed:
    """The sweep by the command line."""
    started = time.perf_counter()
    subprocess.run([*COMMAND, str(sweep), "--out", str(folder), *options], check=True, stdout=subprocess.DEVNULL)
    return finished(folder, time.perf_counter() - started)


def on_cluster(sweep: Path, folder: Path, kill_after: int | None) -> Timed:
    """The sweep on two workers, of which one is killed (`kill -9`) when `kill_after` runs are finished."""
    from distributed import Client, LocalCluster  # noqa: PLC0415 (an extra)

    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        started = time.perf_counter()
        address = str(cluster.scheduler_address)
        command = [*COMMAND, str(sweep), "--out", str(folder), "--cluster", address]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
            if kill_after is not None:
                while process.poll() is None and finished_runs(folder) < kill_after:
                    time.sleep(0.05)
                victim = next(iter(client.run(os.getpid).values()))
                assert process.poll() is None, "the sweep ended before a worker could be killed"
                os.kill(victim, signal.SIGKILL)
            if process.wait() != 0:
                raise RuntimeError(f"the sweep ended with status {process.returncode}")
        return finished(folder, time.perf_counter() - started)


def finished_runs(folder: Path) -> int:
    """How many runs lie in the folder of a sweep."""
    return sum(not path.name.startswith(".") for path in (folder / RUNS).iterdir()) if (folder / RUNS).is_dir() else 0


def finished(folder: Path, wall: float) -> Timed:
    """A finished sweep with the digest of every file but the times and the record that names the sweep's file."""
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.name not in (TIMES, RECORD):
            digest.update(str(path.relative_to(folder)).encode() + b"\0" + path.read_bytes())
    with (folder / TIMES).open(encoding="utf-8", newline="") as stream:
        runs = [float(row["wall_s"]) for row in csv.DictReader(stream)]
    return Timed(wall, runs, digest.hexdigest())


def text_of(found: dict[str, tuple[Timed, int]], arguments: argparse.Namespace) -> str:
    """The result as Markdown."""
    rows = [
        f"| {name} | {len(result.runs)} | {result.wall:.1f} | {sum(result.runs) / workers:.1f} | "
        f"{result.ratio(workers):.2f} | `{result.digest[:12]}` |"
        for name, (result, workers) in found.items()
    ]
    same = len({result.digest for result, _ in found.values()}) == 1
    words = (
        "All files but `times.csv` are the same byte for byte." if same else "The files are NOT the same byte for byte."
    )
    explanation = (
        "A worker that is killed (`kill -9`) is replaced by its nanny, and its run is done again. The time includes "
        "reading the sweep and one import of the program per worker. The digest is of every file below the sweep's "
        f"folder but `times.csv`. {words} `{TABLE}` beside this page is that of the last sweep."
    )
    head = "| where | finished runs | time (s) | runs' own time / workers (s) | ratio | digest of the results |"
    command = f"python -m benchmarks.sweep_on_cluster {arguments.sweep} --out {arguments.out}"
    body = "\n".join(textwrap.wrap(explanation, 120))
    return (
        f"# A sweep on a cluster of which one worker is killed\n\n```\n{command}\n```\n\n"
        + "\n".join([head, "| --- | ---: | ---: | ---: | ---: | --- |", *rows])
        + f"\n\n{body}\n"
    )


if __name__ == "__main__":
    main()
