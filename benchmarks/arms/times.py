"""Processor time and memory of a diagnosis of positions, over the number of rows.

`python -m benchmarks.arms.times [--rows N ...] [--kinds KIND ...] [--results FOLDER]`. Every diagnosis runs in a
process of its own, on one thread; reading the file is included, writing the report is not. Times are processor time, so
that other work on the machine counts little. What is done already is not done again: `times.json` grows row by row.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from benchmarks.arms.plant import Faults, recordings, usual_faults
from benchmarks.single_thread import ONE_THREAD

ROWS = (100, 300, 700, 2000, 5000)
KINDS = {
    "many": "zeros, all links, all stiffnesses, a tool of unknown mass and a runout are off",
    "few": "two zeros, all stiffnesses and a runout are off",
    "outside": "stiffnesses, and the zero of joint 4 that jumps by 1 mrad at 0.7 rad: in no library",
}
_TEMPERATURE, _SECONDS = 21.0, 20.0


def faults(kind: str) -> Faults:
    """What is wrong with the arm."""
    softness = np.array([1.0, 1.3, 1.2, 0.8, 1.1, 0.9])
    if kind == "many":
        return usual_faults(1)
    if kind == "few":
        return Faults(zeros=np.array([0.0, 1e-3, 0.0, 5e-4, 0.0, 0.0]), softness=softness, periodic=(2e-4, 1.0))
    return Faults(softness=softness, slip=1e-3)


def one(kind: str, rows: int) -> dict[str, object]:
    """One diagnosis in this process."""
    from expdesign.chain.recordings.reader import read_recordings  # noqa: PLC0415
    from expdesign.diagnosis.diagnose import diagnose  # noqa: PLC0415 (its import is not timed)
    from expdesign.mechanics.robots.robot_file import read_robot  # noqa: PLC0415

    table = recordings(faults(kind), rows, rows)
    table["time_s"] = _SECONDS * (table["sequence"] // 3)
    table["temperature_degC"] = _TEMPERATURE + np.sin(table["time_s"] / 3000.0)
    robot = read_robot(Path("configs/robots/ur5.yaml"))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "positions.csv"
        table.to_csv(file, index=False)
        start = time.process_time()
        found = diagnose(robot, read_recordings(file, robot))
        seconds = time.process_time() - start
    return {
        "kind": kind,
        "rows": rows,
        "seconds": round(seconds, 1),
        "memory_GB": round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6, 2),
        "verdict": found.verdict,
        "method": found.method.name,
        "held_out": round(found.errors.test_after, 3),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rows", type=int, nargs="+", default=list(ROWS))
    parser.add_argument("--kinds", nargs="+", default=list(KINDS))
    parser.add_argument("--results", type=Path, default=Path("results/arms"))
    parser.add_argument("--one", nargs=2, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.one:
        print(json.dumps(one(arguments.one[0], int(arguments.one[1]))))
        return
    arguments.results.mkdir(parents=True, exist_ok=True)
    file = arguments.results / "times.json"
    done = json.loads(file.read_text(encoding="utf-8")) if file.exists() else []
    for rows in arguments.rows:
        for kind in arguments.kinds:
            if any(entry["kind"] == kind and entry["rows"] == rows for entry in done):
                continue
            command = [sys.executable, "-m", "benchmarks.arms.times", "--one", kind, str(rows)]
            run = subprocess.run(command, check=True, capture_output=True, text=True, env={**os.environ, **ONE_THREAD})
            done.append(json.loads(run.stdout.splitlines()[-1]))
            file.write_text(json.dumps(done, indent=1) + "\n", encoding="utf-8")
            print(done[-1], flush=True)


if __name__ == "__main__":
    main()
