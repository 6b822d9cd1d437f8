"""How far recommended plans are above the bound of `total`, and what they cost.

    python -m research.benchmarks.fronts.bounds CONFIG... [--seeds 1 2 3] [--out FILE]

Every configuration is planned to its end, as `expdesign run` plans it. Seconds are processor seconds of one thread:
until the first plan is known, until `total` is within 1 % of its end, of the search, and of the whole run with bounds
and without writing. The bound is of the configuration's own estimator; where it has none, the gap is left out.
"""

import argparse
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from expdesign.planning.optimality.certificate import Certificate
from expdesign.planning.problem_file import read_problem
from expdesign.planning.search import Progress, search
from expdesign.planning.spending import spent

_COLUMNS = ["configuration", "seed", "measurements", "total", "bound", "gap", "first_s", "near_s", "search_s", "all_s"]


@dataclass
class _Watch:
    """Least `total` of a search over its processor time."""

    began: float
    times: list[float]
    totals: list[float]

    def __call__(self, state: Progress) -> None:
        front = np.array(state.front, dtype=float)
        if len(front):
            self.times.append(time.process_time() - self.began)
            self.totals.append(float(np.linalg.norm(front, axis=1).min()))


def planned(config: Path, seed: int) -> list[object]:
    """One configuration, planned to its end: a row of `_COLUMNS`."""
    problem = read_problem(config)
    problem = replace(problem, optimiser=problem.optimiser.with_values(seed=seed))
    watch = _Watch(time.process_time(), [], [])
    problem, front = spent(problem, search(problem, watch))
    searched = time.process_time() - watch.began
    bound = Certificate(problem, 1.0).bound(front.decisions).value
    total = float(front.criteria["total"].min())
    near = next((at for at, known in zip(watch.times, watch.totals, strict=True) if known <= 1.01 * total), searched)
    gap = np.nan if bound is None else total / bound - 1.0
    measurements = problem.space.measurements
    whole = time.process_time() - watch.began
    first = watch.times[0] if watch.times else searched
    return [config.stem, seed, measurements, total, bound, gap, first, near, searched, whole]


def main() -> None:
    """Plan, and print a table and its medians."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("configs", type=Path, nargs="+")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument("--out", type=Path, help="CSV")
    arguments = parser.parse_args()
    rows = []
    for config in arguments.configs:
        for seed in arguments.seeds:
            rows.append(planned(config, seed))
            shown = (f"{value:.5g}" if isinstance(value, float) else str(value) for value in rows[-1])
            print(" ".join(shown), flush=True)
    found = pd.DataFrame(rows, columns=_COLUMNS)
    if arguments.out:
        found.to_csv(arguments.out, index=False)
    numbers = found[["gap", "first_s", "near_s", "search_s", "all_s"]]
    print(numbers.describe(percentiles=[0.5, 0.9]).loc[["50%", "90%", "max"]].to_string(float_format="{:.4g}".format))


if __name__ == "__main__":
    main()
