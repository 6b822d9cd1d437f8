"""What is drawn: classes of cases, public seeds for practice, and the files that a tool may read."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml

from ..experiments import FEW, MANY, Extent
from ..generate import case_name
from ..unlisted.cases import Case, Order, draw_case
from ..unlisted.generate import counts_of, orders

PRACTICE_SEEDS = (1, 2, 3, 4, 5)
"""Seeds whose cases anybody may look at, truths included, while a tool is being made."""

EXTENTS: Mapping[str, Extent] = {"few": FEW, "many": MANY}
_STREAMS = {"few": 0, "many": 1}
_MEASURED = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")


@dataclass(frozen=True)
class Question:
    """A case that is still to be drawn: `number` counts from 1, `rows` is few or many, `listed` says of which class."""

    seed: int
    number: int
    order: Order
    rows: str

    @property
    def name(self) -> str:
        return case_name(self.number)

    @property
    def physics(self) -> str:
        """listed, unlisted or none."""
        return {"left_out": "listed", "none": "none"}.get(self.order.family, "unlisted")

    def draw(self) -> Case:
        """The case; the same seed and number give the same one."""
        case = draw_case(self.order, np.random.default_rng([self.seed, self.number, 18]))
        more = {"case": self.name, "seed": self.seed, "physics": self.physics, "extent": self.rows}
        return replace(case, truth=more | case.truth)


def questions(seed: int, count: int, none: int) -> list[Question]:
    """`count` cases of each class (listed or unlisted physics, few or many rows), and `none` consistent ones of each
    extent.
    """
    found: list[tuple[Order, str]] = []
    for rows, extent in EXTENTS.items():
        stream = int(np.random.default_rng([seed, _STREAMS[rows]]).integers(2**40))
        for order in orders(counts_of(count, count, none), stream):
            found.append((replace(order, extent=extent), rows))
    shuffled = np.random.default_rng([seed, 2]).permutation(len(found))
    return [Question(seed, number, *found[index]) for number, index in enumerate(shuffled, start=1)]


def drawn(wanted: list[Question]) -> Iterator[Case]:
    """Their cases, in order."""
    for question in wanted:
        yield question.draw()


def measured_components(case: Case) -> list[str]:
    """Names of the deflections that are measured, in the order of the file."""
    return [str(name)[len("true_") :] for name in case.later if str(name).startswith("true_")]


def write_question(case: Case, folder: Path) -> None:
    """What a tool may read: robot.yaml, recordings.csv and points.csv, which has no measured columns."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.yaml").write_text(yaml.safe_dump(case.robot, sort_keys=False), encoding="utf-8")
    case.recordings.to_csv(folder / "recordings.csv", index=False)
    points_of(case.later).to_csv(folder / "points.csv", index=False)


def points_of(later: pd.DataFrame) -> pd.DataFrame:
    """The rows to be predicted, without what was measured or is true."""
    secret = [name for name in later if str(name).startswith(("true_", "base_")) or _is_reading(str(name))]
    return later.drop(columns=secret)


def _is_reading(column: str) -> bool:
    return column in {f"{kind}{axis}" for kind in "ds" for axis in _MEASURED}


def write_truth(case: Case, folder: Path) -> None:
    """What a tool may not read: truth.yaml, and later.csv with readings and true deflections."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "truth.yaml").write_text(yaml.safe_dump(case.truth, sort_keys=False), encoding="utf-8")
    case.later.to_csv(folder / "later.csv", index=False)


def read_case(question: Path, truth: Path) -> Case:
    """A case from its two folders."""
    read: dict[str, Any] = yaml.safe_load((truth / "truth.yaml").read_text(encoding="utf-8"))
    robot = yaml.safe_load((question / "robot.yaml").read_text(encoding="utf-8"))
    return Case(robot, pd.read_csv(question / "recordings.csv"), pd.read_csv(truth / "later.csv"), read)
