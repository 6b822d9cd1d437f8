"""Held-out errors, processor times and parameters of ways to calibrate an arm from positions, on the same rows.

    python -m research.benchmarks.arms_positions [--figaroh PYTHON] [--pybotics PYTHON] [--seeds N] [--out FOLDER]
        [--ways PATTERN] [--sets PATTERN] [--recorded ROBOT.yaml JOINT,... RECORDINGS.csv ...]

Simulated arms (of the kind of a UR10, an IRB 120, a seven-axis arm; `machine.py`) are judged by held-out positions
without noise, recordings by the rows that their column `split` marks `test`. The ways are the drawn robot with
instrument and markers fitted, a script with SciPy (`script.py`) with and without compliances, `identify`, FIGAROH at
five levels and pybotics. The last two run in interpreters of their own (`pip install figaroh`, `pip install pybotics`)
and are left out, with a message, where none is named. FIGAROH's level `priors` is its estimation method `map`. pybotics
has one tool, and takes minutes for an arm.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import re
import tempfile
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pandas as pd

from research.benchmarks.arms_positions.machine import KINDS
from research.benchmarks.arms_positions.rows import POSES, Rows, recorded, simulated
from research.benchmarks.arms_positions.ways import UnavailableError, ways


def every(given: argparse.Namespace, folder: Path) -> Iterator[tuple[int, Rows]]:
    """The rows of all sets with the seeds of the simulated ones."""
    if given.recorded:
        robot, joints, *files = given.recorded
        for file in files:
            yield 0, recorded(Path(robot), Path(file), tuple(joints.split(",")))
        return
    for seed in range(given.seeds):
        for design in POSES:
            for kind in KINDS:
                if re.search(given.sets, f"{kind}, {design}"):
                    yield seed, simulated(kind, design, seed, folder)


def summary(done: pd.DataFrame) -> pd.DataFrame:
    """Means over arms with standard errors of the mean (0 of a single one)."""
    lines = []
    for (name, way), mine in done.groupby(["set", "way"], sort=False):
        errors = np.array(mine["rms_um"])
        spread = errors.std(ddof=1) / np.sqrt(len(errors)) if len(errors) > 1 else 0.0
        lines.append(
            {
                "set": name, "way": way, "arms": len(errors), "rms_um": errors.mean(), "standard_error_um": spread,
                "max_um": mine["max_um"].max(), "parameters": mine["parameters"].mean(),
                "seconds": mine["seconds"].mean(),
            }
        )  # fmt: skip
    return pd.DataFrame(lines)


def main() -> None:
    """The table, on standard output and in `--out`."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--figaroh", help="interpreter that has FIGAROH")
    parser.add_argument("--pybotics", help="interpreter that has pybotics")
    parser.add_argument("--seeds", type=int, default=5, help="simulated arms of each kind")
    parser.add_argument("--recorded", nargs="+", help="robot file, its joints as in the URDF, recordings")
    parser.add_argument("--ways", default="", help="regular expression of the names of the ways that are gone")
    parser.add_argument("--sets", default="", help="regular expression of the names of the simulated sets")
    parser.add_argument("--out", type=Path, default=Path("results/arms"))
    given = parser.parse_args()
    print("expdesign, numpy, scipy, pin:", *(version(each) for each in ("expdesign", "numpy", "scipy", "pin")))
    name = "peers-recorded" if given.recorded else "peers"
    lines: list[dict[str, object]] = []
    with tempfile.TemporaryDirectory() as scratch:
        for seed, rows in every(given, Path(scratch)):
            for way, calibrated in ways(given.figaroh, given.pybotics).items():
                if not re.search(given.ways, way):
                    continue
                try:
                    found = calibrated(rows)
                except UnavailableError as reason:
                    print(f"{rows.name}: {way}: {reason}", flush=True)
                    continue
                errors = 1e6 * np.linalg.norm(found.positions - rows.truth[rows.held_out], axis=-1)
                lines.append(
                    {
                        "set": rows.name, "seed": seed, "way": way, "rms_um": float(np.sqrt((errors**2).mean())),
                        "max_um": float(errors.max()), "parameters": found.parameters, "seconds": found.seconds,
                    }
                )  # fmt: skip
                print(*lines[-1].values(), sep=", ", flush=True)
            given.out.mkdir(parents=True, exist_ok=True)
            summary(pd.DataFrame(lines)).to_csv(given.out / f"{name}.csv", index=False, float_format="%.4g")


if __name__ == "__main__":
    main()
