"""Cases outside the library: `python -m benchmarks.concealed.unlisted.generate --out DIR --truth DIR2 --count 150`.

DIR/case-001/ holds robot.yaml and recordings.csv, which a diagnosis may read; DIR2/case-001/ holds truth.yaml and
later.csv, which it may not.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import yaml
from benchmarks.single_thread import single_threaded

from ..generate import case_name, fresh_seed
from ..robots import HEXAPODS
from .cases import FAMILIES, LISTED, OTHER_FORMS, RECIPES, UNLISTED, Case, Order, draw_case

SHARES = {"alone": 0.50, "pair": 0.15, "beside": 0.15, "form": 0.20}
"""Of the cases that are neither `left_out` nor `none`."""
SHARE_BIPOD = 0.14


def orders(counts: dict[str, int], seed: int, only: Sequence[str] = ()) -> list[Order]:
    """What the cases shall be, in random order. `counts`: cases of each family; `only`: names of recipes."""
    rng = np.random.default_rng([seed, 0])
    strange, forms = (
        _in_turn([n for n in names if not only or n in only] or list(names), rng) for names in (UNLISTED, OTHER_FORMS)
    )
    listed, made_for = (
        _in_turn([n for n in LISTED if not only or n in only] or list(LISTED), rng),
        _in_turn(list(RECIPES), rng),
    )
    found = []
    for family, count in counts.items():
        for _ in range(count):
            physics = _physics(family, strange, forms, listed, made_for, rng)
            able = all(RECIPES[name].planar for name in physics)
            robot = "bipod" if able and rng.random() < SHARE_BIPOD else str(rng.choice(list(HEXAPODS)))
            found.append(Order(family, physics, robot))
    return [found[index] for index in rng.permutation(len(found))]


def _physics(
    family: str,
    strange: Iterator[str],
    forms: Iterator[str],
    listed: Iterator[str],
    made_for: Iterator[str],
    rng: np.random.Generator,
) -> tuple[str, ...]:
    single = {"alone": strange, "form": forms, "left_out": listed, "none": made_for}
    if family in single:
        return (next(single[family]),)
    while True:
        first, second = next(strange), next(strange if family == "pair" else listed)
        fits = RECIPES[first].wishes(rng).compatible(RECIPES[second].wishes(rng))
        if first != second and fits and RECIPES[second].pairs and second != "geometric_stiffness":
            return first, second


def _in_turn(names: Sequence[str], rng: np.random.Generator) -> Iterator[str]:
    while True:
        yield from (names[index] for index in rng.permutation(len(names)))


def counts_of(count: int, left_out: int, none: int) -> dict[str, int]:
    """Cases of each family: `count` outside the library in the shares of `SHARES`, beside the other two."""
    found = {family: round(count * share) for family, share in SHARES.items()}
    found["alone"] += count - sum(found.values())
    return found | {"left_out": left_out, "none": none}


def generate(work: Sequence[tuple[int, int, Order]], jobs: int = 2) -> Iterator[Case]:
    """The cases of (seed, number, order), in order; the same seed gives the same, whatever the number of processes."""
    if jobs == 1:
        yield from map(drawn, work)
        return
    with single_threaded(), ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        for done, case in enumerate(pool.map(drawn, work, chunksize=1), start=1):
            print(f"\rgenerated {done} of {len(work)}", end="", file=sys.stderr, flush=True)
            yield case
    print(file=sys.stderr)


def drawn(job: tuple[int, int, Order]) -> Case:
    """One case."""
    seed, number, order = job
    case = draw_case(order, np.random.default_rng([seed, number]))
    return replace(case, truth={"case": case_name(number), "seed": seed} | case.truth)


def write_questions(case: Case, folder: Path) -> None:
    """What a diagnosis may read."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.yaml").write_text(yaml.safe_dump(case.robot, sort_keys=False), encoding="utf-8")
    case.recordings.to_csv(folder / "recordings.csv", index=False)
    for name, text in case.files.items():
        (folder / name).write_text(text, encoding="utf-8")


def write_truth(case: Case, folder: Path) -> None:
    """What it may not read."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "truth.yaml").write_text(yaml.safe_dump(case.truth, sort_keys=False), encoding="utf-8")
    case.later.to_csv(folder / "later.csv", index=False)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, help="what a diagnosis may read")
    parser.add_argument("--truth", type=Path, required=True, help="what it may not read")
    parser.add_argument("--count", type=int, default=150, help="cases outside the library")
    parser.add_argument("--left-out", type=int, default=0, help="further cases of listed physics whose entries go")
    parser.add_argument("--none", type=int, default=0, help="further consistent cases")
    parser.add_argument("--seed", type=int, help="default: drawn afresh")
    parser.add_argument("--only", action="append", default=[], help="names of recipes")
    parser.add_argument("--family", choices=FAMILIES, help="only this family")
    parser.add_argument("--jobs", type=int, default=2)
    chosen = parser.parse_args()
    seed = fresh_seed() if chosen.seed is None else chosen.seed
    counts = {chosen.family: chosen.count} if chosen.family else counts_of(chosen.count, chosen.left_out, chosen.none)
    work = [(seed, number, order) for number, order in enumerate(orders(counts, seed, chosen.only), start=1)]
    started = time.monotonic()
    for case in generate(work, chosen.jobs):
        write_questions(case, chosen.out / case.truth["case"])
        write_truth(case, chosen.truth / case.truth["case"])
    print(f"{len(work)} cases, seed {seed}, {time.monotonic() - started:.0f} s", file=sys.stderr)


if __name__ == "__main__":
    main()
