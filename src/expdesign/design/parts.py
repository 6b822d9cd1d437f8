"""Work on one design problem that falls into parts which do not need each other.

A part is a function of the problem and of plain arguments, so that it may be done anywhere: here one after another, or
by workers that have read the same configuration (`sweeps/problem_work.py`). The results are the same.
"""

from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeVar

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.design.problem import DesignProblem

R = TypeVar("R")
Done = Callable[[int], None]
"""Called with the index of a part when it is done, in whatever order that happens."""


def unnoticed(index: int) -> None:
    """The report of who does not want one."""


class Parts(Protocol):
    """Does the parts of a work."""

    def __call__(self, work: Callable[..., R], arguments: Sequence[tuple[Any, ...]], done: Done = unnoticed) -> list[R]:
        """`work(problem, *each)` of all arguments, in their order."""


Executor = Callable[[DesignProblem], Parts]
"""What does the parts of works on a problem."""

_WORTHWHILE = 8
"""Rows of a work below which it is not divided."""


def by_halves(
    parts: Parts, work: Callable[..., FloatArray], rows: tuple[FloatArray | IntArray, ...], common: tuple[Any, ...]
) -> FloatArray:
    """`work(problem, *rows, *common)` (b, ...), of every other row by itself, whoever does that, so that results do not
    depend on it to the last bit.

    Args:
        parts: does the two halves.
        work: a function of rows that do not need each other.
        rows: arrays (b, ...).
        common: arguments that are the same for all rows.
    """
    count = len(rows[0])
    if count < _WORTHWHILE:
        return parts(work, [(*rows, *common)])[0]
    first, second = parts(work, [(*(each[start::2] for each in rows), *common) for start in (0, 1)])
    result = np.empty((count, *first.shape[1:]))
    result[::2], result[1::2] = first, second
    return result


def one_after_another(problem: DesignProblem) -> Parts:
    """Does the parts here."""

    def execute(work: Callable[..., R], arguments: Sequence[tuple[Any, ...]], done: Done = unnoticed) -> list[R]:
        results = []
        for index, each in enumerate(arguments):
            results.append(work(problem, *each))
            done(index)
        return results

    return execute
