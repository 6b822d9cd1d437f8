"""What a run ends with: fronts and bounds of many configurations at the default's own end.

    python -m research.benchmarks.fronts.ends record NAME FOLDER CONFIG... [--seed SEED] [--effort EFFORT]
    python -m research.benchmarks.fronts.ends table NAME FOLDER > PAGE

`record` searches each configuration with its own settings, or another seed or effort, and bounds DUIR and `total`, with
whatever version of the program is imported; one file for each configuration, under the name of the version, which is
not made again where it is there. `table` compares one version with all that any version in the folder found:
hypervolumes in parts of that of all fronts of a configuration together, the reference point a tenth of their common
extent beyond their worst values. Seconds are processor seconds of the search.
"""

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.front import hypervolume, non_dominated, reference_point
from expdesign.planning.optimality.certificate import Certificate
from expdesign.planning.problem_file import read_problem
from expdesign.planning.search import search

CLOSE = 1e-3
"""Relative distance from the best that is known within which an end of the front counts as found."""


def record(name: str, folder: Path, configs: list[Path], changes: dict[str, Any]) -> None:
    """Keep the fronts and bounds of default runs."""
    folder.mkdir(parents=True, exist_ok=True)
    for config in configs:
        kept = folder / f"{config.stem}.{name}.json"
        if kept.exists():
            continue
        problem = read_problem(config)
        problem = replace(problem, optimiser=problem.optimiser.with_values(**changes))
        started = time.process_time()
        front = search(problem)
        seconds = time.process_time() - started
        bounds = [Certificate(problem, factor).bound(front.decisions).value for factor in (0.0, 1.0)]
        found = {
            "front": np.stack([front.criteria["duir"], front.criteria["feir"]], axis=1).tolist(),
            "kktpm": float(np.nanmax(front.kktpm)) if np.isfinite(front.kktpm).any() else None,
            "seconds": seconds,
            "bounds": bounds,
            "missing": front.missing,
        }
        kept.write_text(json.dumps(found), encoding="utf-8")
        print(f"{config.stem}: {seconds:.1f} s, {len(front)} designs, bounds {bounds}", flush=True)


def row(name: str, every: dict[str, dict[str, Any]]) -> dict[str, float]:
    """One configuration: a version's result beside all of them."""
    fronts = {other: np.array(result["front"]) for other, result in every.items()}
    known: FloatArray = np.concatenate(list(fronts.values()))
    best = known[non_dominated(known)]
    point, own = reference_point(best), fronts[name]
    total, duir = np.linalg.norm(own, axis=1).min(), own[:, 0].min()
    lower = every[name].get("bounds") or [None, None]
    return {
        "hypervolume": hypervolume(own, point) / hypervolume(best, point),
        "total": total / np.linalg.norm(known, axis=1).min() - 1.0,
        "duir": duir / known[:, 0].min() - 1.0,
        "to bound of DUIR": np.nan if lower[0] is None else 1.0 - lower[0] / known[:, 0].min(),
        "to bound of total": np.nan if lower[1] is None else 1.0 - lower[1] / np.linalg.norm(known, axis=1).min(),
        "designs": len(own),
        "s": every[name]["seconds"],
    }


def table(name: str, folder: Path) -> None:
    """Print one version's ends as Markdown, and their summary."""
    rows: dict[str, dict[str, float]] = {}
    for file in sorted(folder.glob(f"*.{name}.json")):
        config = file.name.split(".")[0]
        every = {other.name.split(".")[1]: json.loads(other.read_text()) for other in folder.glob(f"{config}.*.json")}
        rows[config] = row(name, every) | {"versions": len(every)}
    columns = list(next(iter(rows.values())))
    values = {column: np.array([each[column] for each in rows.values()]) for column in columns}
    parts, seconds, several = values["hypervolume"], values["s"], int((values["versions"] > 1).sum())
    print(f"- {len(rows)} configurations, of which {several} were searched by another version too")
    print(f"- hypervolume: median {np.median(parts):.4f}, worst {parts.min():.4f}, {(parts < 0.95).sum()} below 0.95")
    for what in ("total", "duir"):
        close = int((values[what] <= CLOSE).sum())
        print(f"- least {what} within 0.1 % of the best known in {close}, furthest above it {values[what].max():.1e}")
    for what in ("to bound of DUIR", "to bound of total"):
        share = values[what][np.isfinite(values[what])]
        if len(share) == 0:
            continue
        print(
            f"- {what}: median {np.median(share):.2%}, largest {share.max():.1%}, {(share < -1e-9).sum()} above a plan"
        )
    print(f"- processor seconds of a search: median {np.median(seconds):.1f}, longest {seconds.max():.1f}\n")
    print("| configuration | " + " | ".join(columns) + " |")
    print("| --- |" + " --- |" * len(columns))
    for config, each in rows.items():
        print(f"| {config} | " + " | ".join(f"{each[column]:.4g}" for column in columns) + " |")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    for command in ("record", "table"):
        each = commands.add_parser(command)
        each.add_argument("name")
        each.add_argument("folder", type=Path)
        if command == "record":
            each.add_argument("configs", type=Path, nargs="+")
            each.add_argument("--seed", type=int)
            each.add_argument("--effort", choices=("quick", "normal", "thorough"))
    arguments = parser.parse_args()
    if arguments.command == "record":
        changes = {
            name: getattr(arguments, name) for name in ("seed", "effort") if getattr(arguments, name) is not None
        }
        record(arguments.name, arguments.folder, arguments.configs, changes)
    else:
        table(arguments.name, arguments.folder)


if __name__ == "__main__":
    main()
