"""What the front of a run lacks against long searches: `python -m benchmarks.fronts.proof [--first 1 --last 50]`.

Every configuration (`configurations.py`) is searched with the default settings, and then by long searches with other
seeds, a larger population and many times the generations. Hypervolumes are of (DUIR, FEIR), in parts of that of all
these fronts together, with a reference point a tenth of their common extent beyond their worst values. Seconds are
processor seconds of one thread. Results are kept one by one, so that an interrupted proof goes on where it stopped.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import datetime
import json
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.design.front import hypervolume, non_dominated, reference_point
from expdesign.design.problem import DesignProblem
from expdesign.design.search import search

from .configurations import problem

FOLDER = Path("results/fronts")
SEEDS, EFFORT, POPULATION = (1001, 1002), 12, 200
"""Seeds of the long searches, their generations in those of the settings, and their population."""


def searched(found: DesignProblem) -> dict[str, Any]:
    """One search: its front, processor seconds, and estimate of what it lacks."""
    begun = time.process_time()
    front = search(found)
    seconds = time.process_time() - begun
    values = np.stack([front.criteria[name] for name in front.objectives], axis=1)
    largest = float(np.nanmax(front.kktpm)) if np.isfinite(front.kktpm).any() else None
    return {"front": values.tolist(), "seconds": seconds, "missing": front.missing, "kktpm": largest}


def measured(number: int, kept: Path) -> dict[str, Any]:
    """The searches of configuration `number`, from the file that keeps them where it is there."""
    if kept.exists():
        stored: dict[str, Any] = json.loads(kept.read_text(encoding="utf-8"))
        return stored
    with tempfile.TemporaryDirectory() as folder:
        found = problem(number, Path(folder))
    settings = found.optimiser
    searched(replace(found, optimiser=replace(settings, population=4, generations=2)))  # what is compiled once
    result = {"default": searched(found), "long": []}
    for seed in SEEDS:
        longer = replace(settings, seed=seed, generations=EFFORT * settings.generations, population=POPULATION)
        result["long"].append(searched(replace(found, optimiser=longer)))
    kept.parent.mkdir(parents=True, exist_ok=True)
    kept.write_text(json.dumps(result), encoding="utf-8")
    return result


def row(number: int, result: dict[str, Any]) -> dict[str, Any]:
    """What the table says of one configuration."""
    fronts = [np.array(each["front"]) for each in (result["default"], *result["long"])]
    everything = np.concatenate(fronts)
    best = everything[non_dominated(everything)]
    point = reference_point(best)
    largest = hypervolume(best, point)
    parts = [hypervolume(front, point) / largest for front in fronts]
    least = float(everything[:, 0].min())
    return {
        "number": number,
        "default": parts[0],
        "long": parts[1:],
        "duir": float(fronts[0][:, 0].min()) / least - 1.0,
        "missing": result["default"]["missing"],
        "kktpm": result["default"]["kktpm"],
        "designs": len(fronts[0]),
        "seconds": result["default"]["seconds"],
        "longer": sum(each["seconds"] for each in result["long"]),
    }


def page(rows: list[dict[str, Any]], command: str) -> str:
    """The table and its summary, as Markdown."""
    parts: FloatArray = np.array([each["default"] for each in rows])
    duir = np.array([each["duir"] for each in rows])
    seconds = np.array([each["seconds"] for each in rows])
    longer = np.array([each["longer"] for each in rows])
    lines = [
        "# Fronts against long searches",
        "",
        f"Command: `{command}`. Date: {datetime.datetime.now(datetime.UTC).date()}. Configurations "
        f"{', '.join(str(each['number']) for each in rows)} of `python -m benchmarks.fronts.configurations`, seeds of the "
        f"default searches their numbers, of the {len(SEEDS)} long ones {', '.join(map(str, SEEDS))}, with {EFFORT} times "
        f"the generations and a population of {POPULATION}. Processor seconds of one thread on a shared machine.",
        "",
        f"- hypervolume of the default search in parts of that of all three fronts together: median {np.median(parts):.4f}, "
        f"worst {parts.min():.4f}; at least 0.998 in {int((parts >= 0.998).sum())} of {len(parts)}, at least 0.99 in "
        f"{int((parts >= 0.99).sum())}",
        f"- least DUIR within 1e-6 of the least of all in {int((duir <= 1e-6).sum())} of {len(rows)}; furthest above it "
        f"{duir.max():.1e}",
        f"- processor seconds of a default search: median {np.median(seconds):.1f}, longest {seconds.max():.1f}; the long "
        f"searches together took {np.median(longer / seconds):.0f} times as long (median)",
        "",
        "| number | hypervolume | of the long ones | DUIR above the least | estimated missing | largest KKTPM | designs | s | "
        "long, together (s) |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for each in rows:
        missing = "–" if each["missing"] is None else f"{each['missing']:.4f}"
        largest = "–" if each["kktpm"] is None else f"{each['kktpm']:.0e}"
        long = ", ".join(f"{part:.4f}" for part in each["long"])
        lines.append(
            f"| {each['number']} | {each['default']:.4f} | {long} | {each['duir']:.0e} | {missing} | {largest} | "
            f"{each['designs']} | {each['seconds']:.1f} | {each['longer']:.0f} |"
        )
    return "\n".join([*lines, ""])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--last", type=int, default=50)
    parser.add_argument("--kept", type=Path, default=Path("results/fronts/kept"), help="searches already done")
    arguments = parser.parse_args()
    rows = []
    for number in range(arguments.first, arguments.last + 1):
        rows.append(row(number, measured(number, arguments.kept / f"random-{number:02d}.json")))
        print(rows[-1], flush=True)
        command = f"python -m benchmarks.fronts.proof --first {arguments.first} --last {rows[-1]['number']}"
        FOLDER.mkdir(parents=True, exist_ok=True)
        (FOLDER / "hypervolume.md").write_text(page(rows, command), encoding="utf-8")


if __name__ == "__main__":
    main()
