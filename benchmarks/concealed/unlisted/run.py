"""Outside the library, in one command: `python -m benchmarks.concealed.unlisted.run` generates, asks and scores.

150 cases outside the library, 60 of listed physics whose entries are left out, 200 consistent ones, from a seed that is
drawn afresh unless one is given. With `--keep DIR` what has been answered is not asked again: the same command with the
same seed goes on where it stopped.
"""

from __future__ import annotations

import argparse
import datetime
import shlex
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from benchmarks.single_thread import single_threaded

from ..generate import fresh_seed
from .cases import FAMILIES, Case
from .generate import counts_of, generate, orders, write_truth
from .judgement import Judged, judge
from .program import Program
from .score import frame, markdown


def examine(program: Program, cases: Sequence[Case], jobs: int) -> list[Judged]:
    """Have all cases diagnosed, several at a time, then judge."""
    outcomes = []
    with single_threaded(), ThreadPoolExecutor(jobs) as pool:
        for done, outcome in enumerate(pool.map(program.ask, cases), start=1):
            outcomes.append(outcome)
            print(f"\rdiagnosed {done} of {len(cases)}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    names = [str(case.truth["case"]) for case in cases]
    return [judge(c, o, program.answers(n)) for c, o, n in zip(cases, outcomes, names, strict=True)]


def publish(text: str, judged: Sequence[Judged], results: Path | None, stem: str) -> None:
    """Print a page, and write it with its table into a folder where there is one."""
    print(text)
    if results:
        results.mkdir(parents=True, exist_ok=True)
        (results / f"{stem}.md").write_text(text, encoding="utf-8")
        frame(judged).to_csv(results / f"{stem}.csv", index=False)
        print(results / f"{stem}.md")


def main() -> None:
    chosen = _arguments()
    fresh = chosen.seed is None
    seed = fresh_seed() if fresh else chosen.seed
    counts = {chosen.family: chosen.count} if chosen.family else counts_of(chosen.count, chosen.left_out, chosen.none)
    work = [(seed, number, order) for number, order in enumerate(orders(counts, seed, chosen.only), start=1)]
    work = work[: chosen.limit]
    started, today = time.monotonic(), datetime.datetime.now(datetime.UTC).date().isoformat()
    print(f"seed {seed}", file=sys.stderr)
    with tempfile.TemporaryDirectory(prefix="concealed-") as scratch:
        folder = (chosen.keep or Path(scratch)).resolve()
        program = Program(shlex.split(chosen.command), folder)
        cases = list(generate(work, chosen.jobs))
        generated = time.monotonic() - started
        judged = examine(program, cases, chosen.jobs)
        if chosen.keep:
            for case in cases:
                write_truth(case, folder / "truth" / case.truth["case"])
    facts = [
        f"{today}, seed {seed}{' (drawn afresh)' if fresh else ' (given)'}",
        f"{chosen.jobs} at a time; generating took {generated:.0f} s, everything {time.monotonic() - started:.0f} s",
    ]
    text = markdown(judged, "Outside the library", facts)
    stem = f"{today}-{seed}-outside{'' if fresh else '-development'}"
    publish(text, judged, chosen.results or chosen.keep, stem)


def _arguments() -> argparse.Namespace:
    program = Path(sys.executable).with_name("expdesign")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=150, help="cases outside the library (of --family: of it)")
    parser.add_argument("--left-out", type=int, default=60, help="cases of listed physics whose entries are left out")
    parser.add_argument("--none", type=int, default=200, help="consistent cases")
    parser.add_argument("--limit", type=int, help="only the first so many of all cases")
    parser.add_argument("--family", choices=FAMILIES, help="only this family")
    parser.add_argument("--only", action="append", default=[], help="names of recipes")
    parser.add_argument("--seed", type=int, help="default: drawn afresh; with a seed it is no proof")
    parser.add_argument("--jobs", type=int, default=2, help="processes at a time")
    parser.add_argument("--keep", type=Path, help="folder for cases, answers and, afterwards, truths; resumes")
    parser.add_argument("--results", type=Path, help="folder for the table")
    parser.add_argument("--command", default=str(program), help="the program that diagnoses and predicts")
    return parser.parse_args()


if __name__ == "__main__":
    main()
