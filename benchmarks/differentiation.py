"""What gradients cost, paired against another state of the program.

`python -m benchmarks.differentiation [--against SRC] [--results FOLDER]`: processor milliseconds (best of many
repetitions) of criteria without and with gradients, of the certificate's sensitivity and of its candidates, for the
hexapod and the bipod in large and small batches. `SRC` is the folder `src` of another state of the program, which is
timed right after each measurement of this one in a process of its own; the ratio is this state over that.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

CONFIGS = ("configs/hexapod-h1.yaml", "configs/bipod.yaml")
SIZES = (100, 16)
REPETITIONS = 30
ROUNDS = 3


def best(function: Callable[[], object]) -> float:
    """Least processor time of a call (ms)."""
    function()
    times = []
    for _ in range(REPETITIONS):
        start = time.process_time()
        function()
        times.append(time.process_time() - start)
    return 1e3 * min(times)


def measured() -> dict[str, float]:
    """Milliseconds by what was timed, with the program that this process imports."""
    found = {}
    for config in CONFIGS:
        for size in SIZES:
            for what, function in _timed(config, size).items():
                found[f"{Path(config).stem}, {size} designs: {what}"] = best(function)
    return found


def _timed(config: str, size: int) -> dict[str, Callable[[], object]]:
    from expdesign.planning.optimality.measurement_maps import MeasurementMaps  # noqa: PLC0415
    from expdesign.planning.optimality.objectives import Objectives  # noqa: PLC0415
    from expdesign.planning.optimality.weights import Dual  # noqa: PLC0415
    from expdesign.planning.problem_file import read_problem  # noqa: PLC0415
    from expdesign.planning.pymoo_problem import DesignPopulation  # noqa: PLC0415
    from expdesign.planning.scalarisation import Aims  # noqa: PLC0415
    from expdesign.planning.start import starting_designs  # noqa: PLC0415

    problem = read_problem(Path(config))
    space, objectives = problem.space, Objectives(problem)
    population, information = DesignPopulation(problem), MeasurementMaps(problem, 1.0)
    designs = starting_designs(problem, size, np.random.default_rng(0)).reshape(size, space.measurements, -1)
    single = designs.reshape(size * space.measurements, -1)
    width = information.rows(single[:1]).shape[2]
    dual = Dual(np.random.default_rng(0).standard_normal((width, 3)), 1.0, 1.0, 5)
    front = objectives.scalarised(Aims(np.zeros((size, 2)), np.ones((size, 2))))
    return {
        "objectives and constraints": lambda: population.objectives(designs),
        "objectives": lambda: objectives.values(designs),
        "objectives with gradients": lambda: front(designs, np.arange(size)),
        "certificate, candidates": lambda: information.rows(single),
        "certificate, sensitivity with gradients": lambda: information.sensitivity(dual, single[:64]),
    }


def in_process(source: Path) -> dict[str, float]:
    """`measured` of the program in a folder."""
    command = [sys.executable, __file__, "--only-measure"]
    environment = os.environ | {"PYTHONPATH": str(source)}
    done = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)
    values: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return values


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--against", type=Path)
    parser.add_argument("--results", type=Path)
    parser.add_argument("--only-measure", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.only_measure:
        print(json.dumps(measured()))
        return
    here = Path(__file__).resolve().parents[1] / "src"
    rounds: list[tuple[dict[str, float], dict[str, float]]] = []
    for _ in range(ROUNDS):
        now = in_process(here)
        rounds.append((now, in_process(arguments.against) if arguments.against else now))
    lines = [
        "# What gradients cost",
        "",
        "Command: `python -m benchmarks.differentiation --against SRC`; processor milliseconds of one thread, best of "
        f"{REPETITIONS} repetitions, median of {ROUNDS} rounds; the ratio is the median of paired ratios.",
        "",
        "| what | before | now | ratio |",
        "| --- | --- | --- | --- |",
    ]
    for what in rounds[0][0]:
        pairs = [(now[what], before[what]) for now, before in rounds]
        now, before = (statistics.median(column) for column in zip(*pairs, strict=True))
        ratio = statistics.median(a / b for a, b in pairs)
        lines.append(f"| {what} | {before:.3f} | {now:.3f} | {ratio:.2f} |")
    text = "\n".join(lines) + "\n"
    print(text)
    if arguments.results:
        arguments.results.mkdir(parents=True, exist_ok=True)
        (arguments.results / "differentiation.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
