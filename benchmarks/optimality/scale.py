"""What each step costs as measurements, targets, variables and candidates grow.

    python -m benchmarks.optimality.scale [CONFIG]

Processor seconds (one thread) on variations of a configuration: m measurements with ten variables each (the pose, the
mass and the centre of mass in all three axes), t targets scattered over the workspace.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import copy
import resource
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml
from benchmarks.optimality.selection import choose_measurements

from expdesign.io.yaml_reader import parse_yaml
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.optimality.certificate import duir_lower_bound, total_lower_bound
from expdesign.planning.optimality.gradient_check import criterion_gradients
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from expdesign.planning.search import search
from expdesign.planning.start import starting_designs

from .tables import write

SIZES = ((6, 1), (6, 10), (6, 100), (25, 1), (100, 1), (100, 10), (100, 100))
GRIDS = (3, 4, 5, 6, 7)


def enlarged(config: dict[str, Any], folder: Path, measurements: int, targets: int) -> DesignProblem:
    """The configuration with so many measurements and targets, and ten variables a measurement."""
    config = copy.deepcopy(config)
    config["experiment"]["measurements"] = measurements
    load = config["experiment"]["load"]
    load["com_z_m"], load["mass_kg"] = [0.1, 0.15], [5.0, 26.5]
    generator = np.random.default_rng(targets)
    first = config["targets"][0]
    config["targets"] = []
    for _ in range(targets):
        pose = generator.uniform(-1.0, 1.0, 6) * [0.02, 0.02, 0.01, 0.08, 0.08, 0.1]
        config["targets"].append({**first, "pose": [float(value) for value in pose]})
    return _problem(config, folder)


def gridded(config: dict[str, Any], folder: Path, points: int) -> DesignProblem:
    """The configuration with so many poses along each axis."""
    config = copy.deepcopy(config)
    bounds = config["experiment"]["poses"].pop("bounds")
    config["experiment"]["poses"]["grid"] = {name: [*limits, points] for name, limits in bounds.items()}
    return _problem(config, folder)


def _problem(config: dict[str, Any], folder: Path) -> DesignProblem:
    return problem_from_document(parse_yaml(yaml.safe_dump(config), "scale.yaml", folder))


def seconds(call: Callable[[], Any], repetitions: int = 3) -> float:
    """Least processor time of some repetitions."""
    times = []
    for _ in range(repetitions):
        start = time.process_time()
        call()
        times.append(time.process_time() - start)
    return min(times)


def sizes(config: dict[str, Any], folder: Path) -> pd.DataFrame:
    rows = []
    names = ["duir", "feir"]
    for measurements, targets in SIZES:
        problem = enlarged(config, folder, measurements, targets)
        space = problem.space
        count = 100 if measurements <= 25 else 20
        drawn = starting_designs(problem, count, np.random.default_rng(0)).reshape(count, measurements, space.decisions)

        def evaluate(problem: DesignProblem = problem, drawn: Any = drawn) -> None:
            assessment = problem.assess(*problem.space.decode(drawn))
            for name in names:
                known_criteria()[name].values(assessment)

        rows.append(
            {
                "measurements": measurements,
                "targets": targets,
                "variables": measurements * space.decisions,
                "DUIR and FEIR (µs a design)": 1e6 * seconds(evaluate) / count,
                "with both gradients (µs)": 1e6 * seconds(partial(criterion_gradients, problem, drawn, names)) / count,
                "bound on DUIR (s)": seconds(partial(duir_lower_bound, problem), 1),
                "bound on total (s)": seconds(partial(total_lower_bound, problem), 1),
                "polish (s)": f"{seconds(partial(search, problem, start=drawn), 1):.3g}"
                if targets == 1
                else "not measured",
            }
        )
        print(rows[-1], flush=True)
    return pd.DataFrame(rows)


def candidates(config: dict[str, Any], folder: Path) -> pd.DataFrame:
    rows = []
    for points in GRIDS:
        problem = gridded(config, folder, points)
        start = time.process_time()
        selection = choose_measurements(problem)
        spent = time.process_time() - start
        rows.append(
            {
                "candidates (pose × extreme load)": points**6 * 8,
                "within the limits": int(selection.bound.certified_on.split("all ")[1].split()[0]),
                "seconds": spent,
                "DUIR": selection.value,
                "bound": selection.bound.value,
                "memory so far (GB)": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6,
            }
        )
        print(rows[-1], flush=True)
    return pd.DataFrame(rows)


def main(path: Path, only: str | None) -> None:
    config = yaml.safe_load(path.read_text(encoding="utf-8"))
    command = f"python -m benchmarks.optimality.scale {path} --only"
    if only != "sizes":
        notes = [
            f"Configuration {path} with a grid of poses: {config['experiment']['measurements']} of so many candidates "
            "by the relaxation, rounding and exchange; processor seconds of everything."
        ]
        found = candidates(config, path.parent)
        write("candidates", "Choosing from many candidates", f"{command} candidates", 1, found, notes)
    if only != "candidates":
        notes = [
            f"Variations of {path}; processor seconds. The polish pursues fewer points, and these less far, the more "
            "variables there are: with 1,000 only the ends of the front, the least total and one point between, in a "
            "few steps each.",
        ]
        write("scale", "What each step costs", f"{command} sizes", 1, sizes(config, path.parent), notes)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("config", nargs="?", type=Path, default=Path("configs/hexapod-h1.yaml"))
    parser.add_argument("--only", choices=["candidates", "sizes"], help="one of the two tables")
    arguments = parser.parse_args()
    main(arguments.config, arguments.only)
