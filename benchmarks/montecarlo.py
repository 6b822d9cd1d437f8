"""What a million repetitions cost: the exact compensation of estimates, and the whole experiment.

`python -m benchmarks.montecarlo [CONFIG] [--samples N] [--results FOLDER]`: processor and wall seconds, on one core,
for a plan drawn at random, and the largest error that is left in a command's fixed point.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from expdesign.assurance.validation.compensation import ExactCompensation
from expdesign.assurance.validation.simulation import simulate
from expdesign.io.output import write_file
from expdesign.planning.plan import Plan
from expdesign.planning.problem_file import read_problem
from expdesign.planning.start import starting_designs

BATCH = 10_000


def timed(work: Callable[[], float]) -> tuple[float, float, float]:
    """Result of some work, its processor seconds and its wall seconds."""
    wall, processor = time.perf_counter(), time.process_time()
    result = work()
    return result, time.process_time() - processor, time.perf_counter() - wall


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("config", nargs="?", type=Path, default=Path("configs/hexapod-h1.yaml"))
    parser.add_argument("--samples", type=int, default=1_000_000)
    parser.add_argument("--results", type=Path)
    options = parser.parse_args()
    problem = read_problem(options.config)
    space = problem.space
    decisions = starting_designs(problem, 1, np.random.default_rng(0))[:1].reshape(
        1, space.measurements, space.decisions
    )
    poses, loads = space.decode(decisions[0])
    plan = Plan(poses, loads, np.arange(1, space.measurements + 1))
    simulate(problem, plan, 100, 1)  # functions are made and mapped before the clock starts
    true = problem.loaded.robot.compliance
    estimates = simulate(problem, plan, min(options.samples, 100_000), 1).estimates
    estimates = np.resize(estimates, (options.samples, len(true)))
    target, wrench = problem.targets.configurations[0], problem.target_wrenches[0]
    compensation = ExactCompensation(problem.loaded, target, wrench, true)

    def compensate() -> float:
        parts = (estimates[start : start + BATCH] for start in range(0, len(estimates), BATCH))
        return max(compensation.attained(part).residual for part in parts)

    works = {
        "exact compensation at one target": compensate,
        f"experiment, identification and exact compensation at {len(problem.targets.weights)} targets": lambda: (
            simulate(problem, plan, options.samples, 1).residual
        ),
    }
    lines = ["| what | processor time (s) | wall time (s) | largest error of a fixed point (m, rad) |"]
    lines.append("| --- | --- | --- | --- |")
    for name, work in works.items():
        residual, processor, wall = timed(work)
        lines.append(f"| {name} | {processor:.1f} | {wall:.1f} | {residual:.1g} |")
    command = f"python -m benchmarks.montecarlo {options.config} --samples {options.samples}"
    text = (
        f"# Monte-Carlo of {options.samples} repetitions\n\n```\n{command}\n```\n\n"
        f"`{problem.loaded.robot.name}`, a plan of {len(plan)} measurements drawn at random, one core. The wall time "
        "is longer where the core is\nshared.\n\n" + "\n".join(lines) + "\n"
    )
    print(text)
    if options.results is not None:
        write_file(options.results / "montecarlo.md", text)


if __name__ == "__main__":
    main()
