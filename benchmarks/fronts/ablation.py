"""What each operator of the search contributes: fronts without it, at equal counted work.

python -m benchmarks.fronts.ablation CONFIG ... [--seconds 4] [--seeds 1 2 3]

The hypervolume of a front is that of the archive, in parts of what all variants and seeds of a configuration found
together. Beside the operators one by one: recombination alone; recombination without pymoo's own mating; and survivors
drawn at random in place of NSGA-II's.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from pymoo.core.population import Population
from pymoo.core.survival import Survival

from expdesign.arrays import FloatArray
from expdesign.planning.evolution import Evolution
from expdesign.planning.front import hypervolume, non_dominated, reference_point
from expdesign.planning.operators.operator import Credit
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import read_problem
from expdesign.planning.search import begun

OPERATORS = ("recombination", "exchange", "pairs", "gradients", "continuation")


class AnySurvive(Survival):  # type: ignore[misc]
    """Survivors at random, none of which counts more than another."""

    def _do(self, problem: Any, pop: Population, *args: Any, n_survive: int, random_state: Any, **kwargs: Any) -> Any:
        survivors = pop[random_state.permutation(len(pop))[:n_survive]]
        survivors.set("rank", np.zeros(len(survivors), dtype=int))
        survivors.set("crowding", random_state.random(len(survivors)))
        return survivors


def keep(found: Evolution, names: tuple[str, ...]) -> None:
    """Leave a search some of its operators."""
    found.operators = [operator for operator in found.operators if operator.name in names]
    found.credit = Credit(len(found.operators), found.credit.floor, found.credit.memory)


def without_mating(found: Evolution) -> None:
    """Leave recombination its children of aims alone."""
    recombination: Any = next(each for each in found.operators if each.name == "recombination")
    recombination._mate = lambda count: Population.new(X=np.zeros((0, found.problem.n_var)))


def any_survive(found: Evolution) -> None:
    """Survivors at random."""
    found.survival = AnySurvive()


def without(name: str) -> Callable[[Evolution], None]:
    """All operators but one."""
    return lambda found: keep(found, tuple(each for each in OPERATORS if each != name))


VARIANTS: dict[str, Callable[[Evolution], None]] = {
    "all": lambda found: None,
    **{f"without {name}": without(name) for name in OPERATORS},
    "recombination alone": lambda found: keep(found, ("recombination",)),
    "without mating": without_mating,
    "survivors at random": any_survive,
}


def searched(problem: DesignProblem, change: Callable[[Evolution], None], seconds: float) -> FloatArray:
    """Criteria (d, k) of the archive after so many counted seconds."""
    found = begun(problem)
    if found.operators:
        change(found)
        while found.state.work.seconds < seconds:
            found.next()
    return found.state.archive.values


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
            seeded = replace(problem, optimiser=replace(problem.optimiser, seed=seed))
            for name, change in VARIANTS.items():
                fronts[name, seed] = searched(seeded, change, given.seconds)
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
