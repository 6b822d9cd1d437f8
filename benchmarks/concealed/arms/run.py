"""Arms: `python -m benchmarks.concealed.arms.run --count 24 --none 12` generates, asks and scores.

The seed is drawn afresh unless one is given; `--keep DIR` resumes.
"""

from __future__ import annotations

import argparse
import datetime
import shlex
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..generate import case_name, fresh_seed
from ..unlisted.program import Program
from ..unlisted.run import examine
from ..unlisted.score import frame, markdown
from .cases import draw_case
from .recipes import RECIPES


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=24)
    parser.add_argument("--none", type=int, default=12, help="consistent cases")
    parser.add_argument("--limit", type=int, help="only the first so many of all cases")
    parser.add_argument("--seed", type=int, help="default: drawn afresh")
    parser.add_argument("--jobs", type=int, default=2, help="diagnoses at a time")
    parser.add_argument("--keep", type=Path, help="folder for cases and answers; resumes")
    parser.add_argument("--results", type=Path, help="folder for the table")
    parser.add_argument("--command", default=str(Path(sys.executable).with_name("expdesign")))
    chosen = parser.parse_args()
    seed = fresh_seed() if chosen.seed is None else chosen.seed
    kinds = [list(RECIPES)[index % len(RECIPES)] for index in range(chosen.count)] + ["none"] * chosen.none
    kinds = [kinds[index] for index in np.random.default_rng([seed, 0]).permutation(len(kinds))][: chosen.limit]
    cases = []
    for number, kind in enumerate(kinds, start=1):
        case = draw_case(kind, np.random.default_rng([seed, number]))
        cases.append(replace(case, truth={"case": case_name(number), "seed": seed} | case.truth))
    with tempfile.TemporaryDirectory(prefix="concealed-") as scratch:
        folder = (chosen.keep or Path(scratch)).resolve()
        judged = examine(Program(shlex.split(chosen.command), folder), cases, chosen.jobs)
    today = datetime.datetime.now(datetime.UTC).date().isoformat()
    text = markdown(judged, "Arms, outside the library", [f"{today}, seed {seed}"])
    print(text)
    results = chosen.results or chosen.keep
    if results:
        results.mkdir(parents=True, exist_ok=True)
        (results / f"{today}-{seed}-arms.md").write_text(text, encoding="utf-8")
        frame(judged).to_csv(results / f"{today}-{seed}-arms.csv", index=False)


if __name__ == "__main__":
    main()
