"""What a case is to those who ask and judge, whoever made it; drawing cases in several processes; where they lie.

FOLDER/cases/case-001 holds robot.yaml and recordings.csv, which a diagnosis may read; FOLDER/truth/case-001 holds
truth.yaml and later.csv (held-out rows), which it may not.
"""

from __future__ import annotations

import secrets
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pandas as pd
import yaml
from numpy.typing import NDArray

from research.benchmarks.single_thread import single_threaded

Order = TypeVar("Order")


class UnsuitableError(Exception):
    """This experiment cannot show this physics; draw another."""


_AXES = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")


@dataclass(frozen=True)
class Case:
    """What a diagnosis may read (`robot`, `recordings`, further `files` by name), and what the judge alone knows.

    `later` are the held-out rows with the noise-free columns `true_*` and, where the judge's own base model does not
    know the robot, its predictions `base_*`.
    """

    robot: dict[str, Any]
    recordings: pd.DataFrame
    later: pd.DataFrame
    truth: dict[str, Any]
    files: dict[str, str] = field(default_factory=dict)

    @property
    def name(self) -> str:
        return str(self.truth["case"])


def fresh_seed() -> int:
    return secrets.randbits(40)


def in_turn(names: Sequence[str], rng: np.random.Generator) -> Iterator[str]:
    """The names in random order, each once, then again in another order."""
    while True:
        yield from (names[index] for index in rng.permutation(len(names)))


def generate(
    draw: Callable[[Order, np.random.Generator], Case], orders: Sequence[Order], seed: int, jobs: int = 1
) -> Iterator[Case]:
    """The cases of orders, in order; the same seed gives the same, whatever the number of processes."""
    work = [(draw, order, seed, number) for number, order in enumerate(orders, start=1)]
    if jobs == 1:
        yield from map(_numbered, work)
        return
    with single_threaded(), ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        for done, case in enumerate(pool.map(_numbered, work, chunksize=1), start=1):
            print(f"\rgenerated {done} of {len(work)}", end="", file=sys.stderr, flush=True)
            yield case
    print(file=sys.stderr)


def _numbered(job: tuple[Callable[[Order, np.random.Generator], Case], Order, int, int]) -> Case:
    """The case of a seed and a number, with its name."""
    draw, order, seed, number = job
    case = draw(order, np.random.default_rng([seed, number]))
    return replace(case, truth={"case": f"case-{number:03d}", "seed": seed} | case.truth)


def first_suitable(
    attempt: Callable[[int], Case], attempts: int, refused: tuple[type[Exception], ...], what: str
) -> Case:
    """The case of the first attempt that is not refused."""
    reasons: list[str] = []
    for number in range(attempts):
        try:
            return attempt(number)
        except refused as error:
            reasons.append(str(error))
    raise RuntimeError(f"{what}: no suitable experiment in {attempts}: {sorted(set(reasons))}")


@dataclass(frozen=True)
class Secant:
    """Secant steps between logarithms of a size and of what it shows.

    `slope`: the first one, `slopes`: the least and the largest, `near`: to the target, `steps`: at most.
    """

    near: float
    steps: int
    slope: float = 1.0
    slopes: tuple[float, float] = (0.4, 4.0)

    def to(
        self, target: float, shown: Callable[[float], float], ends: tuple[float, float], start: float, value: float
    ) -> tuple[float, float]:
        """Where `shown` is about `target`, between two ends, and what is shown there (all logarithms).

        `value` is what is shown at the start.
        """
        at, slope = start, self.slope
        for _ in range(self.steps):
            if abs(value - target) < self.near:
                break
            following = float(np.clip(at + (target - value) / slope, *ends))
            if following == at:
                break
            reached = shown(following)
            slope = float(np.clip((reached - value) / (following - at), *self.slopes))
            at, value = following, reached
        return at, value


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


def read_case(question: Path, truth: Path) -> Case:
    """A case from its two folders."""
    robot, known = (
        yaml.safe_load(file.read_text(encoding="utf-8")) for file in (question / "robot.yaml", truth / "truth.yaml")
    )
    files = {each.name: each.read_text(encoding="utf-8") for each in question.glob("*.urdf")}
    return Case(robot, pd.read_csv(question / "recordings.csv"), pd.read_csv(truth / "later.csv"), known, files)


def kept_cases(folder: Path) -> list[Case]:
    """Cases as an earlier run kept them, truths included."""
    return [read_case(folder / "cases" / each.name, each) for each in sorted((folder / "truth").glob("case-*"))]


def points_of(later: pd.DataFrame) -> pd.DataFrame:
    """The held-out rows without what was measured or is true."""
    readings = {f"{kind}{axis}" for kind in "ds" for axis in _AXES}
    readings |= {f"{kind}{axis}" for kind in ("p", "sp") for axis in _AXES[:3]}
    return later.drop(columns=[n for n in later if n in readings or str(n).startswith(("true_", "base_"))])


def asked_of(case: Case) -> tuple[pd.DataFrame, NDArray[np.bool_]]:
    """Rows to predict, without readings, and which of them are the judge's.

    Held-out rows that lie within the recordings are asked about with those around them: from where a joint came, how
    warm a wall is inside and how far rubber was ever pressed follow from these.
    """
    seen = case.recordings
    if "split" in seen:
        within = (seen["split"] == "test").to_numpy()
        if seen["sequence"][within].tolist() == case.later["sequence"].tolist():
            return points_of(seen.drop(columns="split")), within
    return points_of(case.later), np.ones(len(case.later), dtype=bool)


def measured_components(later: pd.DataFrame) -> list[str]:
    """Names of the readings of held-out rows, in the order of the file."""
    return [str(name)[len("true_") :] for name in later if str(name).startswith("true_")]
