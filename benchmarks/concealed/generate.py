"""Generate concealed cases: `python -m benchmarks.concealed.generate --out DIR --truth DIR2 --count 200`.

DIR/case-001/ holds robot.yaml and recordings.csv, which a diagnosis may read; DIR2/case-001/ holds truth.yaml and
later.csv (further series of the same experiment), which it may not.
"""

from __future__ import annotations

import argparse
import secrets
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

from .cases import INSIDE, OUTSIDE, Case, Order, draw_case
from .robots import HEXAPODS

SHARE_NONE, SHARE_TWO, SHARE_OUTSIDE, SHARE_BIPOD = 0.25, 0.15, 0.10, 0.16


def orders(count: int, seed: int, only: Sequence[str] = ()) -> list[Order]:
    """What the cases shall be, in random order. `only`: identifiers, or none, one, two, outside."""
    rng = np.random.default_rng([seed, 0])
    kinds = _kinds(count, only)
    single = _in_turn([name for name in only if name in INSIDE] or list(INSIDE), rng)
    strange = _in_turn([name for name in only if name in OUTSIDE] or list(OUTSIDE), rng)
    made_for = _in_turn(list(INSIDE), rng)
    found = []
    for kind in kinds:
        names = {"one": single, "outside": strange, "none": made_for}
        physics: tuple[str, ...] = _pair(rng) if kind == "two" else (next(names[kind]),)
        able = all((INSIDE | OUTSIDE)[name].planar for name in physics)
        robot = "bipod" if able and rng.random() < SHARE_BIPOD else str(rng.choice(list(HEXAPODS)))
        found.append(Order(kind, physics, robot))
    return [found[index] for index in rng.permutation(count)]


def _kinds(count: int, only: Sequence[str]) -> list[str]:
    if only:
        asked = [name if name in ("none", "one", "two", "outside") else _kind_of(name) for name in only]
        return [asked[index % len(asked)] for index in range(count)]
    none, two, outside = (round(count * share) for share in (SHARE_NONE, SHARE_TWO, SHARE_OUTSIDE))
    return ["none"] * none + ["two"] * two + ["outside"] * outside + ["one"] * (count - none - two - outside)


def _kind_of(name: str) -> str:
    if name in INSIDE:
        return "one"
    if name in OUTSIDE:
        return "outside"
    raise SystemExit(f"--only {name}: known are none, one, two, outside, {', '.join([*INSIDE, *OUTSIDE])}")


def _in_turn(names: list[str], rng: np.random.Generator) -> Iterator[str]:
    while True:
        yield from (names[index] for index in rng.permutation(len(names)))


def _pair(rng: np.random.Generator) -> tuple[str, str]:
    names = [name for name, recipe in INSIDE.items() if recipe.pairs]
    while True:
        first, second = (str(name) for name in rng.choice(names, 2, replace=False))
        if INSIDE[first].wishes(rng).compatible(INSIDE[second].wishes(rng)):
            return first, second


def case_name(number: int) -> str:
    return f"case-{number:03d}"


def write_questions(case: Case, folder: Path) -> None:
    """What a diagnosis may read."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.yaml").write_text(yaml.safe_dump(case.robot, sort_keys=False), encoding="utf-8")
    case.recordings.to_csv(folder / "recordings.csv", index=False)


def write_truth(case: Case, folder: Path) -> None:
    """What it may not read."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "truth.yaml").write_text(yaml.safe_dump(case.truth, sort_keys=False), encoding="utf-8")
    case.later.to_csv(folder / "later.csv", index=False)


def generate(count: int, seed: int, only: Sequence[str] = (), jobs: int = 2) -> Iterator[Case]:
    """The cases in order; the same seed gives the same cases, whatever the number of processes."""
    work = [(seed, number, order) for number, order in enumerate(orders(count, seed, only), start=1)]
    if jobs == 1:
        yield from map(_drawn, work)
        return
    with single_threaded(), ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        for done, case in enumerate(pool.map(_drawn, work, chunksize=1), start=1):
            print(f"\rgenerated {done} of {count}", end="", file=sys.stderr, flush=True)
            yield case
    print(file=sys.stderr)


def _drawn(job: tuple[int, int, Order]) -> Case:
    seed, number, order = job
    case = draw_case(order, np.random.default_rng([seed, number]))
    return replace(case, truth={"case": case_name(number), "seed": seed} | case.truth)


def fresh_seed() -> int:
    return secrets.randbits(40)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, help="what a diagnosis may read")
    parser.add_argument("--truth", type=Path, required=True, help="what it may not read")
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, help="default: drawn afresh")
    parser.add_argument("--only", action="append", default=[], help="an identifier, or none, one, two, outside")
    parser.add_argument("--jobs", type=int, default=2)
    chosen = parser.parse_args()
    seed = fresh_seed() if chosen.seed is None else chosen.seed
    started = time.monotonic()
    for case in generate(chosen.count, seed, chosen.only, chosen.jobs):
        write_questions(case, chosen.out / case.truth["case"])
        write_truth(case, chosen.truth / case.truth["case"])
    print(f"{chosen.count} cases, seed {seed}, {time.monotonic() - started:.0f} s", file=sys.stderr)


if __name__ == "__main__":
    main()
