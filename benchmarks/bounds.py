"""How many bounds prove a plan to be the best to one per cent, over random configurations.

python -m benchmarks.bounds [--first 1] [--count 50] [--seconds 60] [--continued] [--folder FOLDER]

Random configurations are those of `benchmarks.fronts.configurations`. Of each the front is searched with the given
population and generations, and DUIR and `total` are bounded by the relaxation, and where that is not close by branch
and bound. After every configuration the table is written anew; `--continued` goes on after its last row.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from expdesign.planning.optimality.bounds import CriterionBounds, criterion_bounds
from expdesign.planning.problem import DesignProblem
from expdesign.planning.search import search

from .fronts.configurations import problem as random_problem

RESULTS = Path("results/bounds")
CLOSE = 0.01
"""Relative distance within which a bound counts as close."""


def poses_of(problem: DesignProblem) -> str:
    """How poses are given."""
    discrete = problem.space.discrete[problem.space.of_pose]
    return "listed" if discrete.all() else "continuous" if not discrete.any() else "mixed"


def row(number: int, problem: DesignProblem, seconds: float) -> dict[str, str | float | int | bool]:
    """One configuration: distances of the best known plan to the bounds without and with branch and bound."""
    start = time.process_time()
    front = search(problem)
    searched = time.process_time() - start
    found: dict[str, str | float | int | bool] = {
        "configuration": number,
        "robot": problem.loaded.robot.kind,
        "m": problem.space.measurements,
        "poses": poses_of(problem),
        "shared reference": problem.noise.shared_reference,
        "aggregate": problem.targets.aggregate,
    }
    for name, factor in (("duir", 0.0), ("total", 1.0)):
        start = time.process_time()
        known = front.decisions
        relaxed: CriterionBounds = criterion_bounds(problem, factor, known, 0.0)
        reached = float(front.criteria[name].min())
        near = relaxed.lower.value is not None and reached <= (1.0 + CLOSE) * relaxed.lower.value
        bounds = relaxed if near else criterion_bounds(problem, factor, known, seconds)
        least = float(np.fmin(reached, bounds.best if np.isfinite(bounds.best) else np.nan))
        lower, first = bounds.lower.value, relaxed.lower.value
        found |= {
            f"least {name}": least,
            f"{name}: relaxation lacks": np.nan if not first else least / first - 1.0,
            f"{name}: bound lacks": np.nan if not lower else least / lower - 1.0,
            f"{name}: front lacks": reached / least - 1.0,
            f"{name}: proved": bounds.finished,
            f"{name} (s)": time.process_time() - start,
        }
    return {**found, "search (s)": searched}


def write(table: pd.DataFrame, command: str, settings: str) -> None:
    """`results/bounds/random.csv` and `.md`."""
    RESULTS.mkdir(parents=True, exist_ok=True)
    table.to_csv(RESULTS / "random.csv", index=False, lineterminator="\n")
    shown = table.copy()
    for column in shown.columns:
        if column.endswith("lacks"):
            shown[column] = [f"{value:.2%}" for value in table[column]]
        elif shown[column].dtype == float:
            shown[column] = [f"{value:.4g}" for value in table[column]]
    lines = ["| " + " | ".join(map(str, cells)) + " |" for cells in (list(shown.columns), *shown.to_numpy().tolist())]
    lines.insert(1, "| " + " | ".join(["---"] * len(shown.columns)) + " |")
    notes = [
        f"- {name}: {int((table[f'{name}: bound lacks'] <= CLOSE).sum())} of {len(table)} bounds are within "
        f"{CLOSE:.0%} of the best known plan; by the relaxation alone "
        f"{int((table[f'{name}: relaxation lacks'] <= CLOSE).sum())}; proved to 0.1 %: "
        f"{int(table[f'{name}: proved'].sum())}. Bounds that a known plan beats: "
        f"{int((table[f'{name}: bound lacks'] < -1e-9).sum())}."
        for name in ("duir", "total")
    ]
    listed = table[table["poses"] == "listed"]
    close = int((listed["duir: bound lacks"] <= CLOSE).sum())
    notes += [
        f"- Of {len(listed)} with listed poses, {close} bounds on DUIR are within {CLOSE:.0%}.",
        f"- {settings} Seconds are of the processor, one thread. `front lacks`: how far the front's least value is "
        "above the least of any plan that is known.",
    ]
    text = ["# Bounds over random configurations", "", f"Command: `{command}`.", "", *lines, "", *notes, ""]
    (RESULTS / "random.md").write_text("\n".join(text), encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--population", type=int, default=100)
    parser.add_argument("--generations", type=int, default=200)
    parser.add_argument("--continued", action="store_true", help="after the last row of the table that is there")
    parser.add_argument("--folder", type=Path, default=Path(tempfile.gettempdir()) / "random-configurations")
    given = parser.parse_args()
    kept = RESULTS / "random.csv"
    rows: list[dict[Any, Any]] = pd.read_csv(kept).to_dict("records") if given.continued and kept.exists() else []
    done = int(rows[-1]["configuration"]) if rows else given.first - 1
    for number in range(done + 1, given.count + 1):
        problem = random_problem(number, given.folder)
        optimiser = replace(problem.optimiser, population=given.population, generations=given.generations)
        rows.append(row(number, replace(problem, optimiser=optimiser), given.seconds))
        options = f"--population {given.population} --generations {given.generations}"
        command = f"python -m benchmarks.bounds --count {given.count} --seconds {given.seconds:g} {options}"
        how = f"Search with population {given.population} and {given.generations} generations"
        branching = f"branch and bound of {given.seconds:g} s where the relaxation is not within {CLOSE:.0%}"
        settings = f"{how}; {branching}."
        write(pd.DataFrame(rows), command, settings)
        print(rows[-1], flush=True)


if __name__ == "__main__":
    main()
