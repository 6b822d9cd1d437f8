"""CPU time of a run with DUIR, FEIR and MEIR against one with the first two alone.

    python -m benchmarks.model_error_cost configs/bipod.yaml configs/hexapod-h1.yaml --out results/model-error/cost.md

Each run is a process of its own: reading, searching, bounding and what `run` writes, without the report. Runs with two
and with three objectives follow each other, pair by pair, so that a machine that grows slower slows both.
"""

import argparse
import os
import statistics
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

from benchmarks.single_thread import ONE_THREAD

import expdesign as xd
from expdesign.io.yaml_reader import read_yaml
from expdesign.planning.problem_file import problem_from_document

OBJECTIVES = (("duir", "feir"), ("duir", "feir", "meir"))


def once(config: str, objectives: list[str]) -> None:
    """One run in this process; prints the CPU time of its search, and that of all of it."""
    document = read_yaml(Path(config))
    problem = problem_from_document(replace(document, content={**document.content, "objectives": objectives}))
    began, searched = time.process_time(), 0.0

    def report(stage: str, done: int, total: int, note: str) -> None:
        nonlocal searched
        if stage == "bounding" and not searched:
            searched = time.process_time() - began

    xd.run(problem, callback=report).files()
    print(searched, time.process_time())


def measured(config: str, objectives: tuple[str, ...]) -> tuple[float, float]:
    """CPU time (s) of the search, and of the whole run with reading and imports."""
    command = [sys.executable, "-m", "benchmarks.model_error_cost", config, "--once", *objectives]
    environment = {**os.environ, **ONE_THREAD}
    found = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    alone, whole = (float(word) for word in found.stdout.split())
    return alone, whole


def table(configs: list[str], pairs: int) -> str:
    """A row per configuration: medians, and the median of the ratios of pairs with the smallest and the largest."""
    lines = [
        "| configuration | search, two (s) | search, three (s) | ratio | run, two (s) | run, three (s) | ratio |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for config in configs:
        found = [[measured(config, objectives) for objectives in OBJECTIVES] for _ in range(pairs)]
        cells = []
        for part in (0, 1):
            two, three = ([pair[k][part] for pair in found] for k in (0, 1))
            ratios = [b / a for a, b in zip(two, three, strict=True)]
            cells += [f"{statistics.median(two):.2f}", f"{statistics.median(three):.2f}"]
            cells.append(f"{statistics.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})")
        lines.append(f"| {config} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Print or write the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("configs", nargs="+")
    parser.add_argument("--pairs", type=int, default=3)
    parser.add_argument("--out", type=Path, help="file to write; printed where left out")
    parser.add_argument("--once", nargs="+", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.once:
        once(options.configs[0], options.once)
        return
    text = table(options.configs, options.pairs)
    if options.out is None:
        print(text)
        return
    command = f"python -m benchmarks.model_error_cost {' '.join(options.configs)} --pairs {options.pairs}"
    options.out.write_text(
        f"# CPU time with MEIR as a third objective\n\n`{command} --out {options.out}`; one core, medians of "
        f"{options.pairs} pairs, the extremes of their ratios in parentheses.\n\n{text}",
        encoding="utf-8",
    )


if __name__ == "__main__":
    main()
