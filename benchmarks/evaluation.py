"""What an evaluation costs, and how much of a run is the genetic algorithm's own work.

`python -m benchmarks.evaluation [CONFIG] [--results FOLDER]`: microseconds per design for both criteria in a population
of 100 (best and median of many repetitions), and where the seconds of a search go.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import statistics
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import expdesign.planning.search as monitored
from expdesign.arrays import FloatArray
from expdesign.planning.optimality.certificate import duir_lower_bound
from expdesign.planning.problem_file import read_problem
from expdesign.planning.pymoo_problem import DesignPopulation
from expdesign.planning.search import search
from expdesign.planning.start import starting_designs

REPETITIONS = 100
SIZE = 100


class Watched(DesignPopulation):
    """The population with a stop-watch on its evaluations."""

    seconds = 0.0

    def objectives(self, decisions: FloatArray) -> tuple[FloatArray, FloatArray]:
        start = time.process_time()
        found = super().objectives(decisions)
        Watched.seconds += time.process_time() - start
        return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("config", nargs="?", type=Path, default=Path("configs/hexapod-h1.yaml"))
    parser.add_argument("--results", type=Path)
    arguments = parser.parse_args()
    problem = read_problem(arguments.config)
    population = DesignPopulation(problem)
    decisions = population.decisions(starting_designs(problem, SIZE, np.random.default_rng(0)))
    population.objectives(decisions)
    times = []
    for _ in range(REPETITIONS):
        start = time.process_time()
        population.objectives(decisions)
        times.append((time.process_time() - start) / SIZE * 1e6)

    monitored.DesignPopulation = Watched  # type: ignore[attr-defined]
    start = time.process_time()
    front = search(replace(problem, optimiser=replace(problem.optimiser, polish=False)))
    genetic = time.process_time() - start
    evaluated = Watched.seconds
    start = time.process_time()
    search(problem, start=front.decisions)
    polished = time.process_time() - start
    start = time.process_time()
    duir_lower_bound(problem, front.decisions)
    bounded = time.process_time() - start
    text = "\n".join(
        [
            f"# What an evaluation costs: {arguments.config}",
            "",
            f"Command: `python -m benchmarks.evaluation {arguments.config}`; processor time of one thread.",
            "",
            "| what | value |",
            "| --- | --- |",
            f"| DUIR and FEIR with constraints, per design, best of {REPETITIONS} | {min(times):.1f} µs |",
            f"| the same, median | {statistics.median(times):.1f} µs |",
            f"| genetic search, {front.evaluations} designs | {genetic:.2f} s |",
            f"| of it our evaluation | {evaluated:.2f} s ({evaluated / genetic:.0%}) |",
            f"| of it the genetic algorithm's own work | {genetic - evaluated:.2f} s ({1 - evaluated / genetic:.0%}) |",
            f"| whole search from that front | {polished:.2f} s |",
            f"| certified lower bound on DUIR | {bounded:.2f} s |",
            "",
        ]
    )
    print(text)
    if arguments.results:
        arguments.results.mkdir(parents=True, exist_ok=True)
        (arguments.results / "evaluation.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
