"""`python -m benchmarks.geometry --experiments 1000 --out results/geometry`: the study and its page."""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

from benchmarks.geometry.page import page
from benchmarks.geometry.study import compensated, repeated


def main() -> None:
    parser = argparse.ArgumentParser(prog="benchmarks.geometry")
    parser.add_argument("--experiments", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("results/geometry"))
    arguments = parser.parse_args()
    start = time.process_time()
    found = repeated(arguments.experiments, arguments.seed)
    found["compensated"] = compensated(min(arguments.experiments, 20), arguments.seed)
    found["processor_s"] = round(time.process_time() - start, 1)
    arguments.out.mkdir(parents=True, exist_ok=True)
    (arguments.out / "study.json").write_text(json.dumps(found, indent=1) + "\n")
    (arguments.out / "README.md").write_text(page(found))
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
