"""One round of concealed cases from drawing to its page, whoever makes the cases.

With `--keep DIR` what has been answered is not asked again: the same command with the same seed goes on where it
stopped. The truths stay in the memory of this process until the last diagnosis has ended.
"""

from __future__ import annotations

import argparse
import datetime
import shlex
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from research.benchmarks.single_thread import single_threaded

from .case import Case, fresh_seed, generate, kept_cases, write_questions, write_truth
from .concealment import orders
from .judgement import Judged, judge
from .program import Program
from .score import frame, markdown


def arguments(description: str | None, jobs: int) -> argparse.ArgumentParser:
    """The options that every source of cases has."""
    program = Path(sys.executable).with_name("expdesign")
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--limit", type=int, help="only the first so many of all cases")
    parser.add_argument("--seed", type=int, help="default: drawn afresh; with a seed it is no proof")
    parser.add_argument("--jobs", type=int, default=jobs, help="processes at a time")
    parser.add_argument("--keep", type=Path, help="folder for cases, answers and, afterwards, truths; resumes")
    parser.add_argument("--kept", type=Path, help="ask about the cases that this folder keeps, instead of drawing")
    parser.add_argument("--generate-only", action="store_true", help="cases and truths to --keep, nothing is asked")
    parser.add_argument("--results", type=Path, help="folder for the page")
    parser.add_argument("--command", default=str(program), help="the program that diagnoses and predicts")
    return parser


def conduct(
    chosen: argparse.Namespace,
    draw: Callable[[int], Iterable[Case]],
    title: str,
    ending: str,
    repeated: int = 0,
    every: bool = False,
) -> None:
    """Draw, ask, judge, and write the page.

    Args:
        chosen: the options of `arguments`.
        draw: makes the cases of a seed.
        title: of the page.
        ending: of the page's name, after date and seed.
        repeated: number of cases that are diagnosed a second time, which must give the same.
        every: whether the page has a table case by case.
    """
    started, today = time.monotonic(), datetime.datetime.now(datetime.UTC).date().isoformat()
    fresh = chosen.seed is None and chosen.kept is None
    if chosen.kept:
        cases = kept_cases(chosen.kept)[: chosen.limit]
        seed = cases[0].truth["seed"]
    else:
        seed = fresh_seed() if chosen.seed is None else chosen.seed
        print(f"seed {seed}", file=sys.stderr)
        cases = list(draw(seed))
    generated = time.monotonic() - started
    with tempfile.TemporaryDirectory(prefix="concealed-") as scratch:
        folder = (chosen.keep or Path(scratch)).resolve()
        program = Program(shlex.split(chosen.command), folder)
        if chosen.generate_only:
            for case in cases:
                write_questions(case, folder / "cases" / case.name)
                write_truth(case, folder / "truth" / case.name)
            return
        judged = examine(program, cases, chosen.jobs)
        same = program.repeatable(cases[:repeated])
        if chosen.keep:
            for case in cases:
                write_truth(case, folder / "truth" / case.name)
    only = f", only {', '.join(chosen.only)}" if chosen.only else ""
    engines = ", ".join(f"{name} {number}" for name, number in cases[0].truth.get("engines", {}).items())
    facts = [
        f"{today}, seed {seed}{' (drawn afresh)' if fresh else ' (given)'}{only}{'; ' if engines else ''}{engines}",
        f"{chosen.jobs} at a time; cases took {generated:.0f} s, everything {time.monotonic() - started:.0f} s",
    ]
    if repeated:
        facts.append(f"diagnosed a second time with the same diagnosis.json: {same} of {len(cases[:repeated])}")
    text = markdown(judged, title, facts, every)
    print(text)
    if results := chosen.results or chosen.keep:
        results.mkdir(parents=True, exist_ok=True)
        stem = f"{today}-{seed}{ending}"
        (results / f"{stem}.md").write_text(text, encoding="utf-8")
        frame(judged).to_csv(results / f"{stem}.csv", index=False)
        print(results / f"{stem}.md")


def conduct_kinds(
    description: str | None,
    kinds: tuple[str, ...],
    draw_case: Callable[[tuple[str, bool], np.random.Generator], Case],
    title: str,
    ending: str,
) -> None:
    """A round of a source whose cases are kinds in turn, and healthy ones: its options, and what `conduct` does."""
    parser = arguments(description, jobs=1)
    parser.add_argument("--count", type=int, default=40, help="cases in which something is hidden")
    parser.add_argument("--healthy", type=int, default=8, help="cases in which nothing is")
    parser.add_argument("--only", action="append", default=[], choices=kinds, help="kinds")
    chosen = parser.parse_args()

    def draw(seed: int) -> Iterator[Case]:
        """One by one, since an engine may be one to a process."""
        wanted = orders(kinds, chosen.count, chosen.healthy, seed, tuple(chosen.only))
        return generate(draw_case, wanted[: chosen.limit], seed)

    conduct(chosen, draw, title, ending, every=True)


def examine(program: Program, cases: Sequence[Case], jobs: int) -> list[Judged]:
    """Have all cases diagnosed, several at a time, then judge."""
    outcomes = []
    with single_threaded(), ThreadPoolExecutor(jobs) as pool:
        for done, outcome in enumerate(pool.map(program.ask, cases), start=1):
            outcomes.append(outcome)
            print(f"\rdiagnosed {done} of {len(cases)}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    return [judge(c, o, program.answers(c.name)) for c, o in zip(cases, outcomes, strict=True)]
