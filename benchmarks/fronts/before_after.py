"""Processor seconds of a run by phase, and its front, against another version's sources.

    python -m benchmarks.fronts.before_after --against SRC [CONFIG ...]

Each side is a process of its own, one after the other, with its default settings. Seconds are processor seconds of one
thread: of starting (imports, reading), until the first front with gradients, of the search, and of both bounds.
Hypervolumes are of (DUIR, FEIR) in parts of that of both fronts together, with a reference point a tenth of their
common extent beyond their worst values.
"""

import argparse
import datetime
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.single_thread import ONE_THREAD

SHIPPED = ("hexapod-h1", "hexapod-120kg", "rubin-camera", "ur5", "bipod")
RESULT = Path("results/fronts/before-and-after.md")
_MEASURE = """
import json, sys, time
from pathlib import Path
import numpy as np
from expdesign.planning.problem_file import read_problem
from expdesign.planning.search import search
from expdesign.planning.optimality.certificate import duir_lower_bound, total_lower_bound
problem = read_problem(Path(sys.argv[1]))
begun = time.process_time()
first = []
front = search(problem, lambda state: first.append(time.process_time() - begun) if len(first) < 2 else None)
searched = time.process_time()
designs = front.decisions if hasattr(front, "decisions") else front.genes  # as earlier versions called them
duir_lower_bound(problem, designs), total_lower_bound(problem, designs)
bounded = time.process_time()
values = np.stack([front.criteria[name] for name in front.objectives], axis=1)
print(json.dumps([values.tolist(), begun, first[-1], searched - begun, bounded - searched]))
"""


def measured(config: Path, sources: Path) -> list[Any]:
    """Front, and seconds of starting, until the first front, of the search and of the bounds."""
    environment = {**os.environ, **ONE_THREAD, "PYTHONPATH": str(sources)}
    command = [sys.executable, "-c", _MEASURE, str(config)]
    done = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)
    found: list[Any] = json.loads(done.stdout.splitlines()[-1])
    return found


def compared(config: Path, before: Path) -> list[str]:
    """Two rows of the table."""
    from expdesign.planning.front import hypervolume, non_dominated, reference_point  # noqa: PLC0415 (as measured)

    sides = [("before", measured(config, before)), ("now", measured(config, Path("src")))]
    fronts = [np.array(side[1][0]) for side in sides]
    together = np.concatenate(fronts)
    best = together[non_dominated(together)]
    point = reference_point(best)
    rows = []
    for (name, (_, *seconds)), front in zip(sides, fronts, strict=True):
        share = hypervolume(front, point) / hypervolume(best, point)
        cells = [
            config.stem,
            name,
            *(f"{value:.2f}" for value in seconds),
            f"{seconds[0] + seconds[2] + seconds[3]:.1f}",
        ]
        rows.append("| " + " | ".join([*cells, str(len(front)), f"{front[:, 0].min():.7g}", f"{share:.4f}"]) + " |")
    return rows


def _revision(sources: Path) -> str:
    """The commit of a checkout."""
    command = ["git", "-C", str(sources), "rev-parse", "--short", "HEAD"]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--against", type=Path, required=True, help="folder `src` of the other version")
    parser.add_argument("configs", nargs="*", type=Path, default=[Path(f"configs/{name}.yaml") for name in SHIPPED])
    arguments = parser.parse_args()
    lines = [
        "# A run before and now",
        "",
        f"Command: `python -m benchmarks.fronts.before_after --against SRC`, SRC of {_revision(arguments.against)}. "
        f"Date: {datetime.datetime.now(datetime.UTC).date()}. Processor seconds of one thread on a shared "
        "machine; seeds as in the configurations; the report and the writing of files are not counted.",
        "",
        "| configuration | | start (s) | first front (s) | search (s) | bounds (s) | all (s) | designs | least DUIR "
        "| hypervolume |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for config in arguments.configs:
        lines += compared(config, arguments.against)
        RESULT.parent.mkdir(parents=True, exist_ok=True)
        RESULT.write_text("\n".join([*lines, ""]), encoding="utf-8")
        print(*lines[-2:], sep="\n", flush=True)


if __name__ == "__main__":
    main()
