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
from pathlib import Path

import numpy as np
import yaml

from .cases import INSIDE, OUTSIDE, Order, draw_case
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


def write_case(job: tuple[int, int, Order, Path, Path]) -> dict[str, object]:
    seed, number, order, out, truth = job
    case = draw_case(order, np.random.default_rng([seed, number]))
    name = f"case-{number:03d}"
    for folder in (out / name, truth / name):
        folder.mkdir(parents=True, exist_ok=True)
    (out / name / "robot.yaml").write_text(yaml.safe_dump(case.robot, sort_keys=False), encoding="utf-8")
    case.recordings.to_csv(out / name / "recordings.csv", index=False)
    known = {"case": name, "seed": seed} | case.truth
    (truth / name / "truth.yaml").write_text(yaml.safe_dump(known, sort_keys=False), encoding="utf-8")
    case.later.to_csv(truth / name / "later.csv", index=False)
    return known


def generate(
    out: Path, truth: Path, count: int, seed: int, only: Sequence[str] = (), jobs: int = 2
) -> list[dict[str, object]]:
    """Write the cases and return their truths."""
    work = [(seed, number + 1, order, out, truth) for number, order in enumerate(orders(count, seed, only))]
    known = []
    with ProcessPoolExecutor(jobs) as pool:
        for done, each in enumerate(pool.map(write_case, work, chunksize=1), start=1):
            known.append(each)
            print(f"\rgenerated {done} of {count}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    (truth / "seed.txt").write_text(f"{seed}\n", encoding="utf-8")
    return known


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
    known = generate(chosen.out, chosen.truth, chosen.count, seed, chosen.only, chosen.jobs)
    print(f"{len(known)} cases, seed {seed}, {time.monotonic() - started:.0f} s", file=sys.stderr)


if __name__ == "__main__":
    main()
