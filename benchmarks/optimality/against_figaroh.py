"""Against FIGAROH's posture selection (`pip install figaroh`): the same pool, the same regressor, as many postures.

    python -m benchmarks.optimality.against_figaroh [CONFIG] [--python INTERPRETER] [--pools 200 500 1000 2000]

FIGAROH weighs the candidates by a D-optimal SOCP and takes the heaviest (its own rule), or exchanges with its DetMax.
This program chooses by the same criterion, O1, from the same matrices; and by DUIR, which is what the plan is for,
where its seconds include making the matrices and proving the bound.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np
import pandas as pd
from benchmarks.optimality.d_optimality import choose_d_optimal
from benchmarks.optimality.selection import choose_measurements

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.optimality.measurement_maps import MeasurementMaps
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import read_problem
from expdesign.planning.start import reachable_measurements

from .tables import write

Result = TypeVar("Result")
NUMBERS = ("seconds", "wall (s)", "det(M/m)^(1/p)", "DUIR")
WORKER = Path(__file__).with_name("figaroh_worker.py")


def figaroh(python: str, rows: FloatArray, count: int, *options: str) -> tuple[list[int], tuple[float, float]]:
    """Indices that FIGAROH chooses, and its processor and wall seconds."""
    with tempfile.TemporaryDirectory() as folder:
        pool, result = Path(folder) / "pool.npz", Path(folder) / "result.json"
        np.savez(pool, information=rows.swapaxes(1, 2) @ rows)
        command = [python, str(WORKER), str(pool), str(count), str(result), *options]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(done.stderr.strip().splitlines()[-1])
        found = json.loads(result.read_text(encoding="utf-8"))
    return found["chosen"], (found["seconds"], found["wall"])


def row(
    problem: DesignProblem,
    pool: int,
    method: str,
    decisions: FloatArray,
    rows: FloatArray,
    chosen: list[int],
    seconds: tuple[float, float],
) -> dict[str, str | float]:
    """One line of the table: what a selection is worth."""
    information = rows[chosen].reshape(-1, rows.shape[-1])
    determinant = np.linalg.det(information.T @ information / len(chosen)) ** (1.0 / rows.shape[-1])
    assessment = problem.assess(*problem.space.decode(decisions[chosen][None]))
    return {
        "pool": pool,
        "method": method,
        "seconds": seconds[0],
        "wall (s)": seconds[1],
        "det(M/m)^(1/p)": float(determinant),
        "DUIR": float(known_criteria()["duir"].values(assessment)[0]),
    }


def timed(call: Callable[[], Result]) -> tuple[Result, tuple[float, float]]:
    """What a call returns, and its processor and wall seconds; once, as FIGAROH's."""
    start, wall = time.process_time(), time.perf_counter()
    result = call()
    return result, (time.process_time() - start, time.perf_counter() - wall)


def main(path: Path, python: str, pools: list[int], seed: int = 1) -> None:
    problem = read_problem(path)
    count = problem.space.measurements
    generator = np.random.default_rng(seed)
    table: list[dict[str, str | float]] = []
    notes = [
        f"Configuration {path}: {count} of the pool's measurements; `seconds` are processor seconds of one thread."
    ]
    for size in pools:
        decisions = reachable_measurements(problem, size, generator)
        rows = MeasurementMaps(problem, 0.0).rows(decisions)
        try:
            for name, options in (("FIGAROH, SOCP", ()), ("FIGAROH, DetMax", ("--detmax",))):
                chosen, seconds = figaroh(python, rows, count, *options)
                table.append(row(problem, size, name, decisions, rows, chosen, seconds))
        except (RuntimeError, FileNotFoundError) as error:
            print(f"FIGAROH does not run with {python} (see `--python`): {error}", file=sys.stderr)
            return
        plan, seconds = timed(partial(choose_d_optimal, rows, count, np.random.default_rng(seed)))
        table.append(row(problem, size, "this program, O1", decisions, rows, list(plan.chosen), seconds))
        bound = plan.bound
        selection, seconds = timed(partial(choose_measurements, problem, decisions))
        index = [int(np.flatnonzero((decisions == one).all(axis=1))[0]) for one in selection.variables]
        table.append(row(problem, size, "this program, DUIR", decisions, rows, index, seconds))
        socp, detmax, ours, best = ({key: float(entry[key]) for key in NUMBERS} for entry in table[-4:])
        criterion = "det(M/m)^(1/p)"
        better = max(socp[criterion], detmax[criterion]) / ours[criterion]
        notes.append(
            f"Pool of {size}: by its own criterion FIGAROH's better selection is at {better:.2%} of this program's, "
            f"which is at {ours[criterion] / bound:.2%} of the proven bound. The SOCP takes "
            f"{socp['seconds'] / ours['seconds']:.0f} times, DetMax {detmax['seconds'] / ours['seconds']:.0f} times as "
            f"long. Its DUIR is {socp['DUIR'] / best['DUIR']:.2f} (SOCP) and {detmax['DUIR'] / best['DUIR']:.2f} "
            f"(DetMax) times that of the choice by DUIR; {selection.bound.value or 0.0:.4g} is proven to be the least."
        )
    command = f"python -m benchmarks.optimality.against_figaroh {path} --pools {' '.join(map(str, pools))}"
    write(f"figaroh-{path.stem}", "Against FIGAROH's posture selection", command, seed, pd.DataFrame(table), notes)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("config", nargs="?", type=Path, default=Path("configs/hexapod-h1.yaml"))
    parser.add_argument("--python", default=sys.executable)
    parser.add_argument("--pools", type=int, nargs="+", default=[200, 500, 1000, 2000])
    arguments = parser.parse_args()
    main(arguments.config, arguments.python, arguments.pools)
