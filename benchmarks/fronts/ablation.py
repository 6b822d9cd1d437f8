"""What each operator of the search contributes: searches without it, at equal counted work.

    python -m benchmarks.fronts.ablation CONFIG... [--seconds 4] [--seeds 1]

Every search goes on until it has done so many counted seconds of work (`operators/operator.py`), the same on any
machine. Hypervolumes are in parts of that of all searches of a configuration together, with a reference point a tenth
of their common extent beyond their worst values; `total` and DUIR are relative to the least of all. `recombination
alone` is NSGA-II with the descents of its children.
"""

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import numpy as np
from pymoo.core.population import Population

from expdesign.arrays import FloatArray
from expdesign.planning import evolution
from expdesign.planning.front import hypervolume, non_dominated, reference_point
from expdesign.planning.operators.operator import Operator, State
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import read_problem
from expdesign.planning.search import search

NAMES = ("recombination", "exchange", "pairs", "gradients", "continuation")
ALL, ALONE = "all", "recombination alone"
RESULT = Path("results/fronts/ablation.md")


def searched(problem: DesignProblem, kept: set[str], seconds: float) -> FloatArray:
    """Objectives (d, k) of the front after so much counted work of the operators with these names."""
    every, states = evolution.operators_of, []

    def some(state: State, mate: Callable[[int], Population]) -> list[Operator]:
        states.append(state)
        return [operator for operator in every(state, mate) if operator.name in kept]

    with patch.object(evolution, "operators_of", some):
        front = search(problem, lambda progress: bool(states) and states[0].work.seconds >= seconds)
    return np.stack([front.criteria[name] for name in front.objectives], axis=1)


def compared(config: Path, seeds: list[int], seconds: float) -> list[str]:
    """Rows of the table: all operators, without each of them, and recombination alone."""
    variants = {ALL: set(NAMES), **{f"without {left}": {*NAMES} - {left} for left in NAMES}, ALONE: {"recombination"}}
    fronts: dict[str, list[FloatArray]] = {name: [] for name in variants}
    for seed in seeds:
        problem = read_problem(config)
        options = replace(problem.optimiser, seed=seed, effort="thorough", generations=None)
        for name, kept in variants.items():
            fronts[name].append(searched(replace(problem, optimiser=options), kept, seconds))
    together = np.concatenate([front for of_seeds in fronts.values() for front in of_seeds])
    best = together[non_dominated(together)]
    point, least, total = reference_point(best), best[:, 0].min(), np.linalg.norm(best, axis=1).min()
    rows = []
    for name, of_seeds in fronts.items():
        shares = [hypervolume(front, point) / hypervolume(best, point) for front in of_seeds]
        totals = [np.linalg.norm(front, axis=1).min() / total - 1.0 for front in of_seeds]
        duirs = [front[:, 0].min() / least - 1.0 for front in of_seeds]
        cells = [f"{np.mean(shares):.4f}", f"{np.mean(totals):.0e}", f"{np.mean(duirs):.0e}"]
        rows.append(f"| {config.stem} | {name} | {' | '.join(cells)} |")
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("configs", type=Path, nargs="+")
    parser.add_argument("--seconds", type=float, default=4.0, help="of counted work")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    arguments = parser.parse_args()
    command = f"python -m benchmarks.fronts.ablation {' '.join(map(str, arguments.configs))}"
    lines = [
        "# What each operator contributes",
        "",
        f"Command: `{command} --seconds {arguments.seconds:g} --seeds {' '.join(map(str, arguments.seeds))}`.",
        "",
        "| configuration | operators | hypervolume | total above the least | DUIR above the least |",
        "| --- | --- | --- | --- | --- |",
    ]
    for config in arguments.configs:
        lines += compared(config, arguments.seeds, arguments.seconds)
        RESULT.write_text("\n".join([*lines, ""]), encoding="utf-8")
        print(*lines[-7:], sep="\n", flush=True)


if __name__ == "__main__":
    main()
