"""What is drawn: classes of cases, and public seeds for practice."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..case import Case, case_name
from ..experiments import FEW, MANY, Extent
from ..unlisted.cases import Order, counts_of, draw_case, orders

PRACTICE_SEEDS = (1, 2, 3, 4, 5)
"""Seeds whose cases anybody may look at, truths included, while a tool is being made."""

EXTENTS: Mapping[str, Extent] = {"few": FEW, "many": MANY}
_STREAMS = {"few": 0, "many": 1}


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
