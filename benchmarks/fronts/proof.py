"""What the front of a run lacks against long searches: `python -m benchmarks.fronts.proof [NUMBER ...]`.

Every configuration (`configurations.py`) is run with the default settings: searched, bounded, and the plans that branch
and bound finds join the front. Then come five long searches. Each of these repeats the search with further seeds, a
larger population and more generations, until it has taken four times the processor time of the default run: twenty
times all together. Hypervolumes are of (DUIR, FEIR), in parts of that of all these fronts together, with a reference
point a tenth of their common extent beyond their worst values. Seconds are processor seconds of one thread. Results are
kept one by one, so that an interrupted proof goes on where it stopped. `--anew` runs the default settings again where
searches are kept, which stay. `--earlier` names a folder of results that another version kept: their fronts count among
those that are known.
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
from expdesign.planning.front import hypervolume, non_dominated, reference_point
from expdesign.planning.optimality.bounds import criterion_bounds
from expdesign.planning.problem import DesignProblem
from expdesign.planning.search import joined, search

from .configurations import problem

FOLDER = Path("results/fronts")
SEEDS, POPULATION = (1001, 2001, 3001, 4001, 5001), 200
"""First seeds of the long searches, their generations in those of the settings, and their population."""
TIMES = 4.0
"""Processor seconds of a long search in those of the default one."""


def searched(found: DesignProblem, *, bounded: bool = False) -> dict[str, Any]:
    """One search, with the plans of branch and bound where wanted: its front, seconds, and what it says it lacks."""
    begun = time.process_time()
    front = search(found)
    if bounded:
        bounds = [criterion_bounds(found, factor, front.decisions) for factor in (0.0, 1.0)]
        front = joined(found, front, [each.plan for each in bounds])
    seconds = time.process_time() - begun
    values = np.stack([front.criteria[name] for name in front.objectives], axis=1)
    largest = float(np.nanmax(front.kktpm)) if np.isfinite(front.kktpm).any() else None
    return {"front": values.tolist(), "seconds": seconds, "missing": front.missing, "kktpm": largest}


def repeated(found: DesignProblem, seconds: float) -> dict[str, Any]:
    """Searches with one seed after another until they took `seconds`: the front of all that they found."""
    spent = 0.0
    searches: list[dict[str, Any]] = []
    while spent < seconds:
        seed = found.optimiser.seed + len(searches)
        searches.append(searched(replace(found, optimiser=replace(found.optimiser, seed=seed))))
        spent += searches[-1]["seconds"]
    values = np.concatenate([each["front"] for each in searches])
    return {"front": values[non_dominated(values)].tolist(), "seconds": spent, "searches": len(searches)}


def measured(number: int, kept: Path, *, anew: bool) -> dict[str, Any]:
    """The searches of configuration `number`, from the file that keeps them where it is there."""
    stored: dict[str, Any] = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {}
    if stored and not anew:
        return stored
    with tempfile.TemporaryDirectory() as folder:
        found = problem(number, Path(folder))
    settings = found.optimiser
    searched(replace(found, optimiser=replace(settings, population=4, generations=2)))  # what is compiled once
    default = searched(found, bounded=True)
    longer = replace(settings, effort="thorough", population=POPULATION)
    long = stored.get("long") or [
        repeated(replace(found, optimiser=replace(longer, seed=s)), TIMES * default["seconds"]) for s in SEEDS
    ]
    result: dict[str, Any] = {"default": default, "long": long}
    kept.parent.mkdir(parents=True, exist_ok=True)
    kept.write_text(json.dumps(result), encoding="utf-8")
    return result


def row(number: int, result: dict[str, Any], earlier: dict[str, Any] | None) -> dict[str, Any]:
    """What the table says of one configuration."""
    others = [earlier["default"], *earlier["long"]] if earlier else []
    fronts = [np.array(each["front"]) for each in (result["default"], *result["long"], *others)]
    everything = np.concatenate(fronts)
    best = everything[non_dominated(everything)]
    point = reference_point(best)
    largest = hypervolume(best, point)
    parts = [hypervolume(front, point) / largest for front in fronts]
    least = float(everything[:, 0].min())
    return {
        "number": number,
        "default": parts[0],
        "long": parts[1 : 1 + len(result["long"])],
        "earlier": parts[1 + len(result["long"]) :],
        # One design may be the best by both.
        "feir": float((fronts[0][:, 1].min() - everything[:, 1].min()) / (np.ptp(best[:, 1]) or 1.0)),
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
    numbers = ", ".join(str(each["number"]) for each in rows)
    seeds = ", ".join(map(str, SEEDS))
    many, few = int((parts >= 0.998).sum()), int((parts >= 0.99).sum())
    equal, ratio = int((duir <= 1e-6).sum()), float(np.median(longer / seconds))
    # Of a front that every search knows, nothing is lacking but rounding.
    estimated = np.array([each["missing"] for each in rows], dtype=float)
    told = np.isfinite(estimated)
    times = (1.0 - parts[told]) / np.maximum(estimated[told], 1e-6)
    lines = [
        "# Fronts against long searches",
        "",
        f"Command: `{command}`. Date: {datetime.datetime.now(datetime.UTC).date()}. Processor seconds of one thread on "
        f"a shared machine. Configurations {numbers} ({len(rows)}) of `python -m benchmarks.fronts.configurations`; "
        f"the default runs have their numbers as seeds; the {len(SEEDS)} long ones begin with {seeds}, have "
        f"thorough effort and a population of {POPULATION}, and are repeated with the next seeds until "
        f"each has taken {TIMES:g} times as long as the default run.",
        "",
        f"- hypervolume of the default run in parts of that of all fronts of a configuration together: median "
        f"{np.median(parts):.4f}, worst {parts.min():.4f}; at least 0.998 in {many} of {len(parts)}, at least 0.99 in "
        f"{few}",
        f"- least DUIR within 1e-6 of the least of all in {equal} of {len(rows)}; furthest above it {duir.max():.1e}",
        f"- what a run says that it lacks is at least what it lacks in {int((times <= 1.0).sum())} of {len(times)}; "
        f"it lacks {np.median(times):.1f} times as much in the median, {np.quantile(times, 0.9):.0f} times in nine of "
        "ten at most",
        f"- processor seconds of a default run: median {np.median(seconds):.1f}, longest {seconds.max():.1f}; the "
        f"long ones together took {ratio:.0f} times as long (median)",
        "",
        "| number | hypervolume | of the long ones | of earlier ones | DUIR above the least "
        "| FEIR above the least, in parts of the front | largest KKTPM | designs | s | long ones (s) |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for each in rows:
        largest = "–" if each["kktpm"] is None else f"{each['kktpm']:.0e}"
        long, earlier = (", ".join(f"{part:.4f}" for part in each[key]) or "–" for key in ("long", "earlier"))
        lines.append(
            f"| {each['number']} | {each['default']:.4f} | {long} | {earlier} | {each['duir']:.0e} | "
            f"{each['feir']:.0e} | {largest} | "
            f"{each['designs']} | {each['seconds']:.1f} | {each['longer']:.0f} |"
        )
    return "\n".join([*lines, ""])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("numbers", nargs="*", type=int, default=list(range(1, 51)), help="configurations")
    parser.add_argument("--kept", type=Path, default=Path("results/fronts/kept"), help="searches already done")
    parser.add_argument("--anew", action="store_true", help="the default settings again, with the long searches kept")
    parser.add_argument("--earlier", type=Path, help="searches that another version kept")
    parser.add_argument("--page", action="store_true", help="the table of the searches already done alone")
    arguments = parser.parse_args()
    rows = []
    for number in arguments.numbers:
        name = f"random-{number:02d}.json"
        if arguments.page and not (arguments.kept / name).exists():
            continue
        path = arguments.earlier / name if arguments.earlier else None
        earlier = json.loads(path.read_text(encoding="utf-8")) if path and path.exists() else None
        rows.append(row(number, measured(number, arguments.kept / name, anew=arguments.anew), earlier))
        print(rows[-1], flush=True)
    FOLDER.mkdir(parents=True, exist_ok=True)
    command = "python -m benchmarks.fronts.proof" + (" --earlier FOLDER" if arguments.earlier else "")
    (FOLDER / "hypervolume.md").write_text(page(rows, command), encoding="utf-8")


if __name__ == "__main__":
    main()
