"""What a search knows over processor time: hypervolume, least total and least DUIR.

    python -m research.benchmarks.fronts.anytime record NAME FOLDER CONFIG... [--seeds 1 2 3] [--naive SECONDS]
        [--estimator weighted]
    python -m research.benchmarks.fronts.anytime table FOLDER

`record` runs searches of whatever version of the program is imported and keeps their fronts as they grow, one file for
each configuration and seed, under the name of the version. `table` compares all versions in the folder: hypervolumes in
parts of what all searches of a configuration know together, total and DUIR relative to the least of all. Seconds are
processor seconds of the search, which begins when the configuration has been read. `--naive` records pymoo's NSGA-II
with its own operators on the same evaluation of designs instead, for so many seconds. `--estimator weighted` judges
plans as versions did that knew no other.
"""

import argparse
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.termination import NoTermination

from expdesign.arrays import FloatArray
from expdesign.planning.front import hypervolume, non_dominated, reference_point
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import read_problem
from expdesign.planning.pymoo_problem import DesignPopulation

SECONDS = (0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, np.inf)


class _Watch:
    """Keeps fronts as they are reported."""

    def __init__(self) -> None:
        self.times: list[float] = []
        self.fronts: list[FloatArray] = []
        self.started = time.process_time()

    def __call__(self, state: Any) -> None:
        self.times.append(time.process_time() - self.started)
        self.fronts.append(np.array(state.front))


def naive(problem: DesignProblem, watch: _Watch, seconds: float) -> None:
    """What NSGA-II knows that has no operators but its own."""
    algorithm = NSGA2(pop_size=problem.optimiser.population)
    algorithm.setup(DesignPopulation(problem), termination=NoTermination(), seed=problem.optimiser.seed)
    while time.process_time() - watch.started < seconds:
        algorithm.next()
        best = algorithm.opt
        front = best.get("F").astype(float)[best.get("feas").ravel()]
        watch(SimpleNamespace(front=front[non_dominated(front)] if len(front) else front))


def record(
    name: str, folder: Path, configs: list[Path], seeds: list[int], seconds: float | None, estimator: str | None
) -> None:
    """Keep the fronts of searches over time."""
    from expdesign.planning import search as module  # noqa: PLC0415 (differs between versions)

    for config in configs:
        for seed in seeds:
            problem = read_problem(config)
            problem = replace(problem, optimiser=problem.optimiser.with_values(seed=seed))
            if estimator is not None:
                problem = replace(problem, estimator=estimator)  # type: ignore[arg-type]
            watch, kktpm = _Watch(), np.ones(1)
            if seconds is not None:
                naive(problem, watch, seconds)
            else:
                found = module.search(problem, watch)
                watch(SimpleNamespace(front=np.stack([found.criteria[each] for each in found.objectives], axis=1)))
                kktpm = np.nan_to_num(found.kktpm, nan=1.0)
            folder.mkdir(parents=True, exist_ok=True)
            extra: dict[str, Any] = {f"front{index}": front for index, front in enumerate(watch.fronts)}
            np.savez(folder / f"{config.stem}.{seed}.{name}.npz", times=np.array(watch.times), kktpm=kktpm, **extra)
            print(f"{config.stem} seed {seed}: {watch.times[-1]:.2f} s, {len(watch.fronts[-1])} designs", flush=True)


def table(folder: Path) -> None:
    """Print what each version knew when, for every configuration and in the mean."""
    files = sorted(folder.glob("*.npz"))
    names = sorted({file.name.split(".")[2] for file in files})
    collected: dict[str, list[FloatArray]] = {name: [] for name in names}
    for config in sorted({file.name.split(".")[0] for file in files}):
        own = [file for file in files if file.name.split(".")[0] == config]
        kept = {file: np.load(file) for file in own}
        known = np.concatenate([data[f"front{i}"] for data in kept.values() for i in range(len(data["times"]))])
        known = known[np.isfinite(known).all(axis=1)]
        best = known[non_dominated(known)]
        point, least = reference_point(best), best.min(axis=0)
        largest, total = hypervolume(best, point), np.linalg.norm(best, axis=1).min()
        print(f"\n{config}: least DUIR {least[0]:.6g}, total {total:.6g}, {len(best)} designs known")
        for name in names:
            rows = []
            for file, data in kept.items():
                if file.name.split(".")[2] == name:
                    rows.append(_row(data, point, largest, float(total), float(least[0])))
            if rows:
                mean = np.mean(rows, axis=0)
                collected[name].append(mean)
                _show(name, mean)
    print("\nmean over configurations")
    for name in names:
        if collected[name]:
            _show(name, np.mean(collected[name], axis=0))


def _row(data: Any, point: FloatArray, largest: float, total: float, duir: float) -> FloatArray:
    times, found = data["times"], []
    for limit in SECONDS:
        place = int(np.searchsorted(times, limit, side="right")) - 1
        if place < 0 or len(data[f"front{place}"]) == 0:
            found.append([0.0, 1.0, 1.0])
            continue
        front = data[f"front{place}"]
        front = front[np.isfinite(front).all(axis=1)]
        found.append(
            [
                hypervolume(front, point) / largest,
                min(1.0, np.linalg.norm(front, axis=1).min() / total - 1.0),
                min(1.0, front[:, 0].min() / duir - 1.0),
            ]
        )
    return np.concatenate([np.array(found).ravel(), [times[-1], (data["kktpm"] > 1e-4).mean()]])


def _show(name: str, row: FloatArray) -> None:
    parts = row[:-2].reshape(-1, 3)
    print(f"  {name:10s} {row[-2]:6.2f} s  hv  " + " ".join(f"{value:7.4f}" for value in parts[:, 0]))
    print(f"  {'':10s} rough {row[-1]:4.2f} tot " + " ".join(f"{value:7.1e}" for value in parts[:, 1]))
    print(f"  {'':21s} duir" + " ".join(f"{value:7.1e}" for value in parts[:, 2]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    recording = commands.add_parser("record")
    recording.add_argument("name")
    recording.add_argument("folder", type=Path)
    recording.add_argument("configs", type=Path, nargs="+")
    recording.add_argument("--seeds", type=int, nargs="+", default=[1])
    recording.add_argument("--naive", type=float, metavar="SECONDS")
    recording.add_argument("--estimator", choices=["generalised", "weighted"])
    commands.add_parser("table").add_argument("folder", type=Path)
    arguments = parser.parse_args()
    if arguments.command == "record":
        known = arguments.name, arguments.folder, arguments.configs, arguments.seeds
        record(*known, arguments.naive, arguments.estimator)
    else:
        table(arguments.folder)


if __name__ == "__main__":
    main()
