"""MEIR against brute force: experiments that hide an effect of the size that MEIR calls just noticed.

    python -m benchmarks.model_error_detection --out results/model-error/detection.md

The check is that of `tests/model_error/test_detection.py`, whose figures are kept here: the share of simulated
experiments in which the test notices the effect, and the largest deviation of the mean error at the targets from the
predicted one, in standard errors of that mean, over all axes of all targets.
"""

import argparse
from pathlib import Path

import numpy as np
from tests.model_error.test_detection import EXPERIMENTS, check

ROBOTS = ("hexapod-h1", "bipod", "ur5")


def main() -> None:
    """Write the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--effects", type=int, default=20)
    options = parser.parse_args()
    lines = []
    for robot in ROBOTS:
        found = check(robot, None, options.effects)
        rates, away = (np.array([row[k] for row in found]) for k in (1, 2))
        summary = f"{100 * rates.min():.1f} to {100 * rates.max():.1f} %, mean {100 * rates.mean():.2f} %"
        within = f"{int((away <= 3.0).sum())} of {len(away)} within 3 standard errors, the largest {away.max():.2f}"
        lines += [f"\n## {robot}\n\n{len(found)} effects: noticed in {summary}; error: {within}.\n"]
        lines += ["| effect | noticed | error, standard errors from the predicted |", "| --- | --- | --- |"]
        lines += [f"| {name} | {100 * rate:.1f} % | {far:.2f} |" for name, rate, far in found]
    opening = (
        f"# Detection at the size that MEIR calls just noticed\n\n`python -m benchmarks.model_error_detection --out "
        f"{options.out}`; {EXPERIMENTS:,} experiments per effect (standard error of a share of 80 %: 0.9 %), six "
        "random measurements, the worst effects that are linear to 1 % at that size.\n"
    )
    options.out.write_text(opening + "\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
