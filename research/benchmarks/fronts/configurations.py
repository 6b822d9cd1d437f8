"""Random run configurations, by number.

    python -m research.benchmarks.fronts.configurations FOLDER [--first 1 --last 50] [--large]

Robots, limits, travel, noise, shared references, load errors, targets, and every form in which poses and loads can be
given: continuous, on a grid, from a list, of a few choices. A number is a seed: the same number gives the same file. A
draw that leaves nothing to choose, or that identifies too little, is followed by the next draw of the same number.
Large ones have 20 to 50 measurements, mostly with a shared reference, and every other one a time for the whole plan.
"""

import argparse
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from expdesign.errors import ExpdesignError
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import read_problem
from expdesign.planning.sampling import require_identifiable, starting_designs

from .robots import ARM, Generator, Mapping, bipod, hexapod, rounded, travel, within

FORMS = ("bounds", "bounds", "bounds", "grid", "candidates", "mixed")
"""How poses are given; `mixed` has choices for some coordinates and bounds for the others."""
_SHIPPED = Path(__file__).parents[3] / "configs" / "robots"
_DRAWS = 50


def write(number: int, folder: Path, *, large: bool = False) -> Path:
    """Write configuration `number` into a folder, with the robot's files or its list of poses beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{'large' if large else 'random'}-{number:02d}.yaml"
    for draw in range(_DRAWS):
        generator = np.random.default_rng([number, draw])
        _write(generator, number, path)
        if large:
            _enlarge(path, number, generator)
        if _sensible(path):
            return path
    raise RuntimeError(f"no sensible configuration {number} in {_DRAWS} draws")


def problem(number: int, folder: Path) -> DesignProblem:
    """The design problem of configuration `number`, whose file is written into a folder."""
    return read_problem(write(number, folder))


def _sensible(path: Path) -> bool:
    try:
        found = read_problem(path)
        space = found.space
        if space.decisions == 0:
            return False
        starts = starting_designs(found, 100, np.random.default_rng(1))
        share = require_identifiable(found, starts)
    except ExpdesignError:
        return False
    # Below that, a configuration asks whether a plan exists rather than which one is best.
    return share >= 0.3


def _write(generator: Generator, number: int, path: Path) -> None:
    kind = generator.choice(["bipod", "hexapod", "serial"], p=[0.2, 0.65, 0.15])
    if kind == "serial":
        for ending in ("yaml", "urdf"):
            shutil.copy(_SHIPPED / f"{ARM}.{ending}", path.parent / f"{ARM}.{ending}")
        robot: Mapping = yaml.safe_load((_SHIPPED / f"{ARM}.yaml").read_text(encoding="utf-8"))
    else:
        robot = bipod(generator) if kind == "bipod" else hexapod(generator)
    ranges = travel(robot, generator)
    # Fewest measurements with which every stiffness can be told, and some more.
    fewest = {"bipod": 1, "hexapod": 2, "serial": 3}[str(kind)]
    load, targets = _load(robot, generator), _targets(robot, ranges, generator)
    experiment: Mapping = {
        "measurements": int(fewest + generator.integers(0, 6)),
        "poses": _poses(ranges, generator, path),
        "load": load,
        "deflection_noise": _noise(robot, generator),
        "load_error": _errors(load, robot, generator),
    }
    document: Mapping = {
        "schema_version": 1,
        "robot": f"{ARM}.yaml" if kind == "serial" else robot,
        "experiment": experiment,
        "targets": targets,
        "aggregate": str(generator.choice(["mean", "mean", "mean", "max"])),
        "objectives": ["duir", "feir"],
        "optimiser": {"seed": number},
    }
    path.write_text(yaml.safe_dump(document, sort_keys=False), encoding="utf-8")


def _enlarge(path: Path, number: int, generator: Generator) -> None:
    """The same experiment as a long campaign: a plan of 20 to 50 measurements, every second one in a given time."""
    document: Mapping = yaml.safe_load(path.read_text(encoding="utf-8"))
    experiment = document["experiment"]
    experiment["measurements"] = int(generator.integers(20, 51))
    experiment["deflection_noise"]["shared_reference"] = bool(generator.random() < 0.7)
    if number % 2 == 0:
        experiment["costs"] = {"pose_change": 2.0, "mass_change": 3.0, "reading": 1.0}
        experiment["budget"] = {"minutes": rounded(experiment["measurements"] * generator.uniform(3.0, 5.0))}
    path.write_text(yaml.safe_dump(document, sort_keys=False), encoding="utf-8")


def _poses(ranges: dict[str, list[float]], generator: Generator, path: Path) -> Mapping:
    form = generator.choice(FORMS)
    if form == "candidates":
        low, high = np.array(list(ranges.values())).T
        table = generator.uniform(low, high, (int(generator.integers(12, 80)), len(low)))
        lines = [",".join(ranges), *(",".join(f"{value:.6g}" for value in row) for row in table)]
        name = f"{path.stem}-poses.csv"
        (path.parent / name).write_text("\n".join(lines) + "\n", encoding="utf-8")
        return {"candidates": name}
    if form == "grid":
        return {"grid": {name: [*ends, int(generator.integers(2, 6))] for name, ends in ranges.items()}}
    bounds: Mapping = dict(ranges)
    for name, (low, high) in ranges.items():
        if form == "mixed" and generator.random() < 0.5:
            bounds[name] = {"choices": [rounded(v) for v in np.linspace(low, high, int(generator.integers(2, 5)))]}
        elif generator.random() < 0.1:
            bounds[name] = 0.0 if low < 0.0 < high else low
    return {"bounds": bounds}


def _quantity(low: float, high: float, generator: Generator) -> Any:
    """An interval, some choices, or a number."""
    form = generator.random()
    if form < 0.55:
        return [rounded(low), rounded(high)]
    if form < 0.9:
        return {"choices": [rounded(v) for v in np.linspace(low, high, int(generator.integers(2, 5)))]}
    return rounded(high)


def _load(robot: Mapping, generator: Generator) -> Mapping:
    if robot["kind"] == "bipod":
        force = within(generator, 200.0, 2000.0)
        return {
            "kind": "wrench",
            "fx_N": _quantity(-0.5 * force, 0.5 * force, generator),
            "fy_N": _quantity(-force, -0.3 * force, generator),
        }
    arm = robot["kind"] == "serial"
    size = 0.1 if arm else 0.4 * robot["home"][2]
    largest = within(generator, 2.0, 5.0) if arm else within(generator, 10.0, 200.0)
    if not arm and generator.random() < 0.25:
        force = 9.81 * largest
        moment = force * size
        load: Mapping = {"kind": "wrench", "fz_N": _quantity(-force, -0.3 * force, generator)}
        load |= {f"f{axis}_N": _quantity(-0.3 * force, 0.3 * force, generator) for axis in "xy"}
        return load | {f"m{axis}_Nm": _quantity(-moment, moment, generator) for axis in "xyz"}
    load = {
        "kind": "payload",
        "mass_kg": _quantity(0.3 * largest, largest, generator),
        "com_x_m": _quantity(-size, size, generator),
        "com_y_m": _quantity(-size, size, generator),
        "com_z_m": rounded(size * generator.uniform(0.3, 1.5)),
    }
    if not arm and generator.random() < 0.2:
        load["gravity"] = {"tilt_x_rad": [0.0, rounded(generator.uniform(0.2, 1.2))]}
    return load


def _noise(robot: Mapping, generator: Generator) -> Mapping:
    size = within(generator, 2e-7, 5e-6) * (10.0 if robot["kind"] == "serial" else 1.0)
    if robot["kind"] == "bipod":
        std = {f"d{axis}_m": rounded(size * generator.uniform(0.5, 2.0)) for axis in "xy"}
    else:
        std = {f"d{axis}_m": rounded(size * generator.uniform(0.5, 2.0)) for axis in "xyz"}
        if generator.random() < 0.8:
            std |= {f"dr{axis}_rad": rounded(size * generator.uniform(2.0, 8.0)) for axis in "xyz"}
    return {"std": std, "shared_reference": bool(generator.random() < 0.35)}


def _errors(load: Mapping, robot: Mapping, generator: Generator) -> list[Mapping]:
    shared = [bool(flag) for flag in generator.random(4) < 0.7]
    planar = robot["kind"] == "bipod"
    forces = [within(generator, 0.1, 5.0)] * (2 if planar else 3)
    wrench = forces if planar else forces + [rounded(0.1 * forces[0])] * 3
    if load["kind"] == "wrench":
        found: list[Mapping] = [{"source": "wrench", "std": wrench, "shared": shared[0]}]
        tilts = [within(generator, 2e-4, 2e-3)] * (1 if planar else 2)
        return found + [{"source": "direction", "std": tilts, "shared": shared[1]}] * int(generator.random() < 0.4)
    possible: list[Mapping] = [
        {"source": "com", "std": [within(generator, 3e-4, 3e-3)] * 3, "shared": shared[0]},
        {"source": "mass", "std": within(generator, 1e-3, 5e-2), "shared": shared[1]},
        {"source": "direction", "std": [within(generator, 2e-4, 2e-3)] * 2, "shared": shared[2]},
        {"source": "wrench", "std": wrench, "shared": shared[3]},
    ]
    chosen = np.flatnonzero(generator.random(4) < 0.6)
    return [possible[index] for index in (chosen if chosen.size else [0])]


def _targets(robot: Mapping, ranges: dict[str, list[float]], generator: Generator) -> list[Mapping]:
    low, high = np.array(list(ranges.values())).T
    planar, arm = robot["kind"] == "bipod", robot["kind"] == "serial"
    size = (1e-4 if arm else 2e-6) * generator.uniform(0.5, 2.0)
    names = [f"d{axis}_m" for axis in ("xy" if planar else "xyz")]
    turns = [] if planar else [f"dr{axis}_rad" for axis in "xyz"]
    found = []
    for _ in range(int(generator.integers(1, 4))):
        pose = (0.5 * (low + high) + 0.3 * (high - low) * generator.uniform(-1.0, 1.0, len(low))).round(4)
        axes = [name for name in names if generator.random() < 0.8] or names[:1]
        tolerance = {name: rounded(size * generator.uniform(0.5, 2.0)) for name in axes}
        tolerance |= {name: rounded(5.0 * size) for name in turns if generator.random() < 0.4}
        target: Mapping = {"pose": pose.tolist(), "tolerance": tolerance, "weight": rounded(generator.uniform(0.5, 2))}
        if planar:
            target["wrench"] = [0.0, -within(generator, 200.0, 2000.0)]
        else:
            lever = 0.08 if arm else 0.3 * robot["home"][2]
            mass = within(generator, 2.0, 5.0) if arm else within(generator, 10.0, 200.0)
            target["payload"] = {
                "mass_kg": mass,
                "com_m": (lever * generator.uniform([-1, -1, 0], 1.0)).round(4).tolist(),
            }
        found.append(target)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--last", type=int, default=50)
    parser.add_argument("--large", action="store_true")
    arguments = parser.parse_args()
    for number in range(arguments.first, arguments.last + 1):
        print(write(number, arguments.folder, large=arguments.large), flush=True)


if __name__ == "__main__":
    main()
