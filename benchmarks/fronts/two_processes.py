"""Time of whole runs by one process and by two: `python -m benchmarks.fronts.two_processes [CONFIG ...] [--rounds 2]`.

Each run is a command of its own, as a user types it, report and files included, one and two processes in turn; of the
rounds the shortest counts. Their fronts and plans must not differ; that of all files
`tests/design/test_second_process.py` sees to. Wall seconds mean something on an idle machine only; processor seconds
are those of both processes.
"""

import argparse
import datetime
import filecmp
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.fronts.before_after import SHIPPED
from benchmarks.single_thread import ONE_THREAD

RESULT = Path("results/fronts/two-processes.md")
_FILES = ("pareto.csv", "plans.csv", "plan.csv")


def timed(config: Path, out: Path, workers: int) -> tuple[float, float]:
    """Wall and processor seconds of a run into a folder."""
    command = [sys.executable, "-m", "expdesign", "run", str(config), "--out", str(out), "--workers", str(workers)]
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(command, env={**os.environ, **ONE_THREAD}, check=True, capture_output=True)
    wall, after = time.perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def compared(config: Path, rounds: int) -> str:
    """A row of the table."""
    least = {1: (float("inf"), float("inf")), 2: (float("inf"), float("inf"))}
    for _ in range(rounds):
        with tempfile.TemporaryDirectory() as folder:
            outs = {workers: Path(folder) / str(workers) for workers in least}
            for workers, out in outs.items():
                least[workers] = min(least[workers], timed(config, out, workers))
            _, *others = filecmp.cmpfiles(outs[1], outs[2], _FILES, shallow=False)
            if any(others):
                raise RuntimeError(f"{config}: two processes give other files than one: {others}")
    (wall, work), (shorter, both) = least[1], least[2]
    figures = (wall, work, shorter, both, wall / shorter)
    return f"| {config.stem} | " + " | ".join(f"{figure:.2f}" for figure in figures) + " | the same |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("configs", nargs="*", type=Path, default=[Path(f"configs/{name}.yaml") for name in SHIPPED])
    parser.add_argument("--rounds", type=int, default=2)
    arguments = parser.parse_args()
    load = os.getloadavg()[0]
    lines = [
        "# Runs by one process and by two",
        "",
        f"Command: `python -m benchmarks.fronts.two_processes --rounds {arguments.rounds}`. Date: "
        f"{datetime.datetime.now(datetime.UTC).date()}. Whole commands, report included, on {os.cpu_count()} cores; "
        f"load average before: {load:.1f}.",
        "",
        "| configuration | one: wall (s) | one: processor (s) | two: wall (s) | two: processor (s) | wall, ratio "
        "| files |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for config in arguments.configs:
        lines.append(compared(config, arguments.rounds))
        RESULT.write_text("\n".join([*lines, ""]), encoding="utf-8")
        print(lines[-1], flush=True)


if __name__ == "__main__":
    main()
