"""Processor time of two states of the program side by side: evaluations, gradients, whole runs, a diagnosis.

`python -m benchmarks.two_states OTHER [--case FOLDER ...] [--rounds N] [--results FILE]`: OTHER is a checkout of
another state (`git worktree add OTHER COMMIT`), a case a folder of `python -m benchmarks.concealed.contest draw`. The
two states are measured in turn on the same machine, and the least of the rounds counts.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

from benchmarks.single_thread import ONE_THREAD

HERE = Path(__file__).parents[1]
CONFIGS = ("configs/bipod.yaml", "configs/hexapod-h1.yaml", "configs/ur5.yaml")
SIZE = 100

EVALUATIONS = """
import json, sys, time
from pathlib import Path
import numpy as np
from expdesign.planning.optimality.gradient_check import criterion_gradients
from expdesign.planning.problem_file import read_problem
from expdesign.planning.pymoo_problem import DesignPopulation
from expdesign.planning.start import starting_designs

problem = read_problem(Path(sys.argv[1]))
population = DesignPopulation(problem)
encode = getattr(population, "decisions", None) or population.genes
designs = encode(starting_designs(problem, int(sys.argv[2]), np.random.default_rng(0)))
works = [lambda: population.objectives(designs), lambda: criterion_gradients(problem, designs, ("duir", "feir"))]
least = []
for work in works:
    work()
    times = []
    for _ in range(15):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    least.append(min(times) / len(designs) * 1e6)
print(json.dumps(least))
"""


def _python(checkout: Path, *arguments: str) -> tuple[str, float]:
    """Output and processor seconds of this interpreter with the package of a checkout."""
    environment = {**os.environ, **ONE_THREAD, "PYTHONPATH": str(checkout / "src")}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [sys.executable, *arguments], cwd=checkout, env=environment, capture_output=True, text=True, check=True
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done.stdout, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measured(checkout: Path, cases: list[Path]) -> dict[str, float]:
    """Every figure of one state, once."""
    found = {}
    for config in CONFIGS:
        name = Path(config).stem
        values, gradients = json.loads(_python(checkout, "-c", EVALUATIONS, config, str(SIZE))[0])
        found[f"{name}: DUIR and FEIR of a design (µs)"] = values
        found[f"{name}: the same with exact gradients (µs)"] = gradients
    with tempfile.TemporaryDirectory() as folder:
        for config in CONFIGS:
            name = Path(config).stem
            seconds = _python(checkout, "-m", "expdesign", "run", config, "--out", f"{folder}/{name}")[1]
            found[f"{name}: whole run (s)"] = seconds
        for case in cases:
            files = (str(case / "robot.yaml"), str(case / "recordings.csv"))
            rows = len((case / "recordings.csv").read_text().splitlines()) - 1
            seconds = _python(checkout, "-m", "expdesign", "diagnose", *files, "--out", f"{folder}/{case.name}")[1]
            found[f"{case.name}: diagnosis of {rows} rows (s)"] = seconds
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("other", type=Path)
    parser.add_argument("--case", type=Path, action="append", default=[], help="folder of a concealed case")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--results", type=Path)
    arguments = parser.parse_args()
    cases = [case.resolve() for case in arguments.case]
    states = {"other": arguments.other.resolve(), "here": HERE}
    rounds = [{name: measured(path, cases) for name, path in states.items()} for _ in range(arguments.rounds)]
    lines = ["| processor time of one thread | other | here | ratio |", "| --- | --- | --- | --- |"]
    for what in rounds[0]["here"]:
        other, here = (min(one[name][what] for one in rounds) for name in states)
        lines.append(f"| {what} | {other:.3g} | {here:.3g} | {here / other:.2f} |")
    text = "\n".join(lines) + "\n"
    print(text, end="")
    if arguments.results is not None:
        arguments.results.write_text(text)


if __name__ == "__main__":
    main()
