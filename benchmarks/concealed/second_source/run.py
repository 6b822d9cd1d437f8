"""The second source in one command: `python -m benchmarks.concealed.second_source.run` generates, asks and scores.

40 cases and 8 healthy ones from a seed that is drawn afresh unless one is given; a seed makes the same cases again,
with the same versions of the engines (extra `second-source`). With `--keep DIR` what has been answered is not asked
again, and `--again DIR` asks another state of the program about cases that were kept, without the engines.
"""

from __future__ import annotations

import argparse
import datetime
import shlex
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from ..generate import case_name, fresh_seed
from ..unlisted.case import Case
from ..unlisted.generate import write_questions, write_truth
from ..unlisted.judgement import Judged
from ..unlisted.program import Program
from ..unlisted.run import examine, publish
from ..unlisted.score import CASE_BY_CASE, by_case, grid, markdown
from .cases import KINDS, draw_case, orders


def generate(count: int, healthy: int, seed: int, only: Sequence[str] = (), limit: int | None = None) -> list[Case]:
    """The cases of a seed, in the order in which they are asked; one by one, since an engine is one to a process."""
    found = []
    for number, (kind, bare) in list(enumerate(orders(count, healthy, seed, tuple(only)), start=1))[:limit]:
        case = draw_case(kind, bare, np.random.default_rng([seed, number]))
        found.append(replace(case, truth={"case": case_name(number), "seed": seed} | case.truth))
        print(f"\rgenerated {len(found)}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    return found


def kept_cases(folder: Path) -> list[Case]:
    """Cases as an earlier run kept them, truths included."""
    found = []
    for path in sorted((folder / "truth").glob("case-*/truth.yaml")):
        own, truth = folder / "cases" / path.parent.name, yaml.safe_load(path.read_text(encoding="utf-8"))
        robot = yaml.safe_load((own / "robot.yaml").read_text(encoding="utf-8"))
        files = {each.name: each.read_text(encoding="utf-8") for each in own.glob("*.urdf")}
        recordings, later = pd.read_csv(own / "recordings.csv"), pd.read_csv(path.parent / "later.csv")
        found.append(Case(robot, recordings, later, truth, files))
    return found


def page(judged: Sequence[Judged], facts: Sequence[str]) -> str:
    """The report of the first source, with a table case by case."""
    text = markdown(judged, "The second source", facts)
    words = [
        "Base and model: held-out RMS in standard deviations of the readings against the true values. Strays: effects,",
        "laws included, at parts that have nothing to do with it. s: processor time.",
    ]
    return text + "\n".join(["", "## Case by case", "", *words, "", *grid(CASE_BY_CASE, by_case(judged)), ""])


def main() -> None:
    chosen = _arguments()
    fresh = chosen.seed is None
    seed = fresh_seed() if fresh else chosen.seed
    started, today = time.monotonic(), datetime.datetime.now(datetime.UTC).date().isoformat()
    if chosen.again:
        cases = kept_cases(chosen.again)
        seed, fresh = cases[0].truth["seed"], False
    else:
        print(f"seed {seed}", file=sys.stderr)
        cases = generate(chosen.count, chosen.healthy, seed, chosen.only, chosen.limit)
    generated = time.monotonic() - started
    with tempfile.TemporaryDirectory(prefix="concealed-") as scratch:
        folder = (chosen.keep or Path(scratch)).resolve()
        if chosen.generate_only:
            for case in cases:
                write_questions(case, folder / "cases" / case.truth["case"])
                write_truth(case, folder / "truth" / case.truth["case"])
            return
        judged = examine(Program(shlex.split(chosen.command), folder), cases, chosen.jobs)
        if chosen.keep:
            for case in cases:
                write_truth(case, folder / "truth" / case.truth["case"])
    used = ", ".join(f"{name} {number}" for name, number in cases[0].truth["engines"].items())
    facts = [
        f"{today}, seed {seed}{' (drawn afresh)' if fresh else ' (given)'}; {used}",
        f"{chosen.jobs} at a time; cases took {generated:.0f} s, everything {time.monotonic() - started:.0f} s",
    ]
    text = page(judged, facts)
    publish(text, judged, chosen.results or chosen.keep, f"{today}-{seed}-second-source")


def _arguments() -> argparse.Namespace:
    program = Path(sys.executable).with_name("expdesign")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=40, help="cases in which something is hidden")
    parser.add_argument("--healthy", type=int, default=8, help="cases in which nothing is")
    parser.add_argument("--limit", type=int, help="only the first so many of all cases")
    parser.add_argument("--only", action="append", default=[], choices=KINDS, help="kinds")
    parser.add_argument("--seed", type=int, help="default: drawn afresh; with a seed it is no proof")
    parser.add_argument("--jobs", type=int, default=1, help="diagnoses at a time")
    parser.add_argument("--keep", type=Path, help="folder for cases, answers and, afterwards, truths; resumes")
    parser.add_argument("--again", type=Path, help="ask about the cases that were kept in this folder")
    parser.add_argument("--generate-only", action="store_true", help="cases and truths to --keep, nothing is asked")
    parser.add_argument("--results", type=Path, help="folder for the page")
    parser.add_argument("--command", default=str(program), help="the program that diagnoses and predicts")
    return parser.parse_args()


if __name__ == "__main__":
    main()
