"""How near the shipped configurations' fronts are to their certified bounds, and to the conditions of optimality.

python -m benchmarks.optimality.bounds [CONFIG ...]
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import time
from pathlib import Path

import numpy as np
import pandas as pd

from expdesign.planning.optimality.certificate import duir_lower_bound, total_lower_bound
from expdesign.planning.problem_file import read_problem
from expdesign.planning.search import search

from .tables import write

CONFIGS = ("bipod", "hexapod-h1", "hexapod-120kg", "rubin-camera")


def row(path: Path) -> dict[str, str | float | int]:
    """One configuration: least DUIR and total, their bounds, and the largest KKT proximity of the front."""
    problem = read_problem(path)
    start = time.process_time()
    front = search(problem)
    searched = time.process_time() - start
    duir, total = duir_lower_bound(problem, front.decisions), total_lower_bound(problem, front.decisions)
    least = {name: float(front.criteria[name].min()) for name in ("duir", "total")}
    return {
        "configuration": path.name,
        "measurements": problem.space.measurements,
        "least DUIR": least["duir"],
        "its bound": duir.value or np.nan,
        "above it": f"{least['duir'] / (duir.value or np.nan) - 1.0:.2%}",
        "least total": least["total"],
        "bound on total": total.value or np.nan,
        "largest kktpm": f"{np.nanmax(front.kktpm):.1e}",
        "designs": len(front),
        "search (s)": searched,
        "bounds (s)": time.process_time() - start - searched,
    }


def main(paths: list[Path]) -> None:
    table = pd.DataFrame([row(path) for path in paths])
    notes = [
        "DUIR and total in tolerances, RMS. Processor seconds of one thread.",
        "The bound on total is that of the best linear estimator, which knows the load errors' statistics; weighted "
        "least squares, which the program uses, does not, so that this bound need not be reached.",
    ]
    names = " ".join(str(path) for path in paths)
    write(
        "bounds", "Distance to the certified bounds", f"python -m benchmarks.optimality.bounds {names}", 1, table, notes
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("configs", nargs="*", type=Path, default=[Path(f"configs/{name}.yaml") for name in CONFIGS])
    main(parser.parse_args().configs)
