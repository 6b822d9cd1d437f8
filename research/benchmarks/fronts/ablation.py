"""What each operator of the search contributes: fronts without it, at equal processor time.

python -m research.benchmarks.fronts.ablation CONFIG ... [--seconds 4] [--seeds 1 2 3]

The hypervolume of a front is that of what is written, in parts of what all variants and seeds of a configuration found
together.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import time
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning import search as module
from expdesign.planning.front import hypervolume, non_dominated, reference_point
from expdesign.planning.operators.state import Operator, State
from expdesign.planning.optimality.objectives import Objectives
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import read_problem

OPERATORS = ("exchange", "children", "repetitions", "descent")
VARIANTS = {"all": OPERATORS, **{f"without {name}": tuple(set(OPERATORS) - {name}) for name in OPERATORS}}


def searched(problem: DesignProblem, names: tuple[str, ...], seconds: float) -> FloatArray:
    """Criteria (d, k) of the front after so many seconds of the processor, with operators of these names alone."""
    every, began = module.operators_of, time.process_time()

    def some(state: State) -> list[Operator]:
        return [operator for operator in every(state) if operator.name in names]

    with patch.object(module, "operators_of", some):
        front = module.search(problem, ended=lambda: "time" if time.process_time() - began > seconds else "")
    return Objectives(problem).values(problem.assessed(front.decisions))


def shares(problem: DesignProblem, fronts: dict[tuple[str, int], FloatArray]) -> dict[tuple[str, int], FloatArray]:
    """Hypervolume, and how far the least `total` and the least first objective are above those of all, by front."""
    count = len(problem.objectives)
    known = np.concatenate(list(fronts.values()))
    best = known[non_dominated(known[:, :count])][:, :count]
    point = reference_point(best)
    whole, least = hypervolume(best, point), known.min(axis=0)
    return {
        key: np.array(
            [
                hypervolume(values[:, :count], point) / whole,
                values[:, -1].min() / least[-1] - 1.0,
                values[:, 0].min() / least[0] - 1.0,
            ]
        )
        for key, values in fronts.items()
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("configs", type=Path, nargs="+")
    parser.add_argument("--seconds", type=float, default=4.0)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    given = parser.parse_args()
    every: dict[str, list[FloatArray]] = {name: [] for name in VARIANTS}
    for config in given.configs:
        problem, fronts = read_problem(config), {}
        for seed in given.seeds:
            seeded = replace(problem, optimiser=problem.optimiser.with_values(seed=seed))
            for name, operators in VARIANTS.items():
                fronts[name, seed] = searched(seeded, operators, given.seconds)
        found = shares(problem, fronts)
        for (name, _), each in found.items():
            every[name].append(each)
        means = {name: np.mean([each[0] for (other, _), each in found.items() if other == name]) for name in VARIANTS}
        print(f"{config.stem}: " + ", ".join(f"{name} {mean:.4f}" for name, mean in means.items()), flush=True)
    table(every)


def table(every: dict[str, list[FloatArray]]) -> None:
    """Print means over all searches, and the standard errors of the differences from all operators."""
    print("\n| operators | hypervolume | against all | total above the least | DUIR above the least |")
    print("| --- | --- | --- | --- | --- |")
    reference = np.array(every["all"])
    for name, rows in every.items():
        values = np.array(rows)
        change = values[:, 0] - reference[:, 0]
        error = change.std(ddof=1) / np.sqrt(len(change)) if len(change) > 1 else np.nan
        mean = values.mean(axis=0)
        print(f"| {name} | {mean[0]:.4f} | {change.mean():+.4f} ± {error:.4f} | {mean[1]:.1e} | {mean[2]:.1e} |")


if __name__ == "__main__":
    main()
