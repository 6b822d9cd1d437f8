"""`python -m research.laboratory ROBOT.yaml PLAN.csv --out FILE --truth TRUTH.yaml --seed N`"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from .errors import LaboratoryError
from .robot import Robot
from .truth import laboratory_from, read_truth


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure a plan in a virtual laboratory; 0 on success, 2 on input that cannot be used."""
    parser = argparse.ArgumentParser(
        prog="python -m research.laboratory", description="Measure a plan on a robot with hidden physics."
    )
    parser.add_argument("robot", type=Path, help="robot file (YAML)")
    parser.add_argument("plan", type=Path, help="plan or recordings (CSV)")
    parser.add_argument("--truth", type=Path, help="true stiffness, noise and elements (YAML)")
    parser.add_argument("--out", type=Path, required=True, help="file to write (CSV)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the noise")
    parser.add_argument("--attained", action="store_true", help="write attained poses instead")
    options = parser.parse_args(arguments)
    try:
        truth = {} if options.truth is None else read_truth(options.truth)
        laboratory = laboratory_from(Robot.read(options.robot), truth, options.seed)
        rows = _read_plan(options.plan)
        measured = laboratory.attained(rows) if options.attained else laboratory.measure(rows)
    except LaboratoryError as error:
        print(f"laboratory: {error}", file=sys.stderr)
        return 2
    measured.to_csv(options.out, index=False)
    return 0


def _read_plan(path: Path) -> pd.DataFrame:
    try:
        return pd.read_csv(path)
    except (OSError, ValueError) as error:
        raise LaboratoryError(f"{path}: cannot be read: {error}") from error


if __name__ == "__main__":
    sys.exit(main())
