"""Against scipy's differential evolution on one number, the total expected error.

    python -m benchmarks.optimality.differential_evolution [CONFIG] [--seconds S]

Both use this program's evaluation of whole populations, scipy's with `vectorized=True` and the masses as integers, and
infeasible designs penalised by how far they are beyond the limits. Pyomo.DoE and pydex are not compared: both expect a
model whose measurements share one vector of design variables and a Fisher information of parameters, and have neither
the target's accuracy nor systematic load errors.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import Bounds, OptimizeResult, differential_evolution

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.optimality.certificate import total_lower_bound
from expdesign.planning.problem_file import read_problem
from expdesign.planning.pymoo_problem import DesignPopulation
from expdesign.planning.search import Progress, search
from expdesign.planning.start import starting_designs

from .tables import write


def main(path: Path, seconds: float, seed: int = 1) -> None:
    problem = read_problem(path)
    total = known_criteria()["total"]
    problem = replace(problem, optimiser=replace(problem.optimiser, seed=seed))
    space = problem.space
    single = DesignPopulation(replace(problem, objectives=(total,)))
    history: list[tuple[float, float]] = []
    spent = time.process_time()

    def penalised(vectors: FloatArray, /) -> Any:
        columns = np.atleast_2d(vectors.T)
        values, violations = single.objectives(single.decisions(columns))
        found: FloatArray = np.where((violations > 0.0).any(axis=1), 10.0 + violations.max(axis=1), values[:, 0])
        found = np.minimum(found, 1e3)
        best = min([found.min(), *(value for _, value in history[-1:])])
        history.append((time.process_time() - spent, float(best)))
        return found

    lower, upper = np.tile(space.lower, space.measurements), np.tile(space.upper, space.measurements)
    integral = np.tile(space.discrete, space.measurements)
    start = starting_designs(problem, 100, np.random.default_rng(seed))

    def enough(intermediate_result: OptimizeResult) -> None:
        if time.process_time() - spent > seconds:
            raise StopIteration

    differential_evolution(
        penalised,
        Bounds(lower, upper),
        init=start,
        integrality=integral,
        vectorized=True,
        updating="deferred",
        maxiter=10**6,
        tol=0.0,
        polish=False,
        rng=np.random.default_rng(seed),
        callback=enough,
    )
    ours: list[tuple[float, float]] = []
    begun = time.process_time()

    def follow(state: Progress) -> None:
        best = float(np.linalg.norm(state.front, axis=1).min()) if len(state.front) else np.inf
        ours.append((time.process_time() - begun, best))

    search(problem, follow, start.reshape(100, space.measurements, space.decisions))
    bound = total_lower_bound(problem).value or np.nan
    rows = []
    least = min(ours[-1][1], history[-1][1])
    for name, trace in (("differential evolution", history), ("this program", ours)):
        levels = {part: least * (1.0 + part) for part in (0.1, 0.05, 0.02, 0.01, 0.001)}
        reach = {f"within {part:.1%} of the best (s)": _first(trace, level) for part, level in levels.items()}
        rows.append({"method": name, **reach, "total at the end": trace[-1][1], "after (s)": trace[-1][0]})
    last = _first(history, history[-1][1])
    same = _first(ours, history[-1][1])
    notes = [
        f"Configuration {path}; seconds are processor seconds of one thread. No plan has a total below {bound:.4g}.",
        f"Differential evolution came to {history[-1][1]:.5g} after {last:.1f} s; this program had as little "
        f"after {same:.2f} s, {last / same:.0f} times faster, with a whole front.",
    ]
    command = f"python -m benchmarks.optimality.differential_evolution {path} --seconds {seconds:g}"
    write(
        f"differential-evolution-{path.stem}",
        "Against differential evolution",
        command,
        seed,
        pd.DataFrame(rows),
        notes,
    )


def _first(trace: list[tuple[float, float]], level: float) -> float:
    return next((seconds for seconds, value in trace if value <= level), np.nan)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("config", nargs="?", type=Path, default=Path("configs/hexapod-h1.yaml"))
    parser.add_argument("--seconds", type=float, default=25.0)
    arguments = parser.parse_args()
    main(arguments.config, arguments.seconds)
