"""Arms whose zeros and frames their recordings confound: what is written is what was said.

    python -m research.benchmarks.confounded_arms --arms 200 --out results/runs/confounded-arms

Simulated UR10e (`arm_groups.py`) of which everything is wrong, with one marker and an unknown instrument, whose zeros
stand for one another. Every arm moves its joints through a drawn part of their ranges (a tenth to all): the less, the
fewer parameters its readings tell apart. Each goes the way of a person (`real_sets.py`): a command writes a model file,
and `predict --readings` reads it.
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np

from research.benchmarks.arm_groups import measured
from research.benchmarks.real_sets import SAME, Outcome, gone_through, write_outcomes

LEAST_PART = 0.1
"""Of the ranges of the joints."""


def main() -> None:
    """A line for every arm, a table in `--out`, and what they come to."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--arms", type=int, default=200)
    parser.add_argument("--first", type=int, default=0, help="seed of the first arm")
    parser.add_argument("--by", default="identify", choices=("identify", "diagnose"))
    parser.add_argument("--out", type=Path, default=Path("results/runs/confounded-arms"), help="table, without ending")
    given = parser.parse_args()
    given.out.parent.mkdir(parents=True, exist_ok=True)
    outcomes: list[Outcome] = []
    with tempfile.TemporaryDirectory() as scratch:
        for seed in range(given.first, given.first + given.arms):
            part = float(np.random.default_rng([seed, 7]).uniform(LEAST_PART, 1.0))
            robot, table, _ = measured(seed, frames=True, folder=Path(scratch), part=part)
            outcomes.append(gone_through(robot, table, f"arm {seed}", f"{part:.2f} of the ranges", given.by))
            print(outcomes[-1], flush=True)
            write_outcomes(given.out.with_suffix(".csv"), outcomes)
    done = [each for each in outcomes if not each.refused]
    written, inside = (np.array([getattr(each, name) for each in done]) for name in ("written", "inside"))
    print(f"{given.by}: {len(done)} of {len(outcomes)} done; file as the report to {SAME:.0%} in "
          f"{(abs(written - 1.0) <= SAME).sum()}, at most {abs(written - 1.0).max():.2%}; held-out readings inside "
          f"{inside.mean():.1%} (of single arms {inside.min():.1%} to {inside.max():.1%}; "
          f"{((inside >= 0.9) & (inside <= 0.98)).sum()} within 90 to 98 %)")  # fmt: skip


if __name__ == "__main__":
    main()
