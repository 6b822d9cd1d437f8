"""What a budget of time gains over a number of measurements that takes as long.

    python -m benchmarks.budget --results results/budget

The hexapod H1 (configs/hexapod-h1.yaml) is planned for the same time twice: with `experiment.budget`, and with as many
measurements as fit where every one has a pose of its own, costs not considered. The least total error of each front
says what is gained. Times are processor seconds of one thread.
"""

import argparse
import time
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from expdesign.io.yaml_reader import YamlDocument
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from expdesign.planning.result import design_minutes, planned
from expdesign.planning.search import search

CONFIG = Path("configs/hexapod-h1.yaml")
COSTS = {"pose_change": 10, "mass_change": 3, "reading": 1}
OPTIMISER = {"seed": 1}
CASES = [(60.0, False), (120.0, False), (60.0, True), (120.0, True)]


def problem(experiment: dict[str, Any]) -> DesignProblem:
    content = yaml.safe_load(CONFIG.read_text(encoding="utf-8"))
    del content["experiment"]["measurements"]
    noise = content["experiment"]["deflection_noise"] | {"shared_reference": experiment.pop("shared")}
    content["experiment"] |= {"costs": COSTS, "deflection_noise": noise} | experiment
    content["optimiser"] = OPTIMISER
    return problem_from_document(YamlDocument(str(CONFIG), CONFIG.parent, content))


def row(name: str, case: DesignProblem) -> tuple[str, float]:
    started = time.process_time()
    front = search(case)
    seconds = time.process_time() - started
    best = front.recommended
    minutes = design_minutes(case, front)
    assert minutes is not None
    plan = planned(case, front.decisions[best])
    poses = len(np.unique(plan.series))
    total = float(front.criteria["total"][best])
    cells = [name, len(plan), poses, f"{minutes[best]:.0f}"]
    cells += [f"{front.criteria[criterion][best]:.4f}" for criterion in ("duir", "feir", "total")]
    return "| " + " | ".join(str(cell) for cell in (*cells, f"{seconds:.0f}")) + " |", total


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--results", type=Path, default=Path("results/budget"))
    results = parser.parse_args().results
    lines = ["| plan | measurements | settings | min | DUIR | FEIR | total | s |", "| --- |" + " --- |" * 7]
    for minutes, shared in CASES:
        limited = problem({"shared": shared, "budget": {"minutes": minutes}})
        budget = limited.budget
        assert budget is not None
        most = max(m for m in range(1, 200) if budget.minutes_of(m, m) <= minutes)
        kind = "shared references" if shared else "references of their own"
        plain, before = row(f"{minutes:.0f} min, {kind}: by number", problem({"shared": shared, "measurements": most}))
        planned, after = row(f"{minutes:.0f} min, {kind}: by budget", limited)
        lines += [plain, planned, f"| *total error less by* | | | | | | {1.0 - after / before:.1%} | |"]
        print("\n".join(lines[-3:]), flush=True)
    results.mkdir(parents=True, exist_ok=True)
    page = results / "README.md"
    text = page.read_text(encoding="utf-8") if page.exists() else "| |\n"
    first, last = text.index("|"), text.rindex("|")
    page.write_text(text[:first] + "\n".join(lines) + text[last + 1 :], encoding="utf-8")


if __name__ == "__main__":
    main()
