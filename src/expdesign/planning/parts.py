"""Work on one design problem that falls into parts which do not need each other.

A part is a function of the problem and of plain arguments, so that it may be done anywhere: here one after another, or
by workers that have read the same configuration (`app/sweeps/engine.py`). The results are the same.
"""

from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeVar

from expdesign.planning.problem import DesignProblem

R = TypeVar("R")
Done = Callable[[int], None]
"""Called with the index of a part when it is done, in whatever order that happens."""


def unnoticed(index: int) -> None:
    """The report of who does not want one."""


class Parts(Protocol):
    """Does the parts of a work."""

    def __call__(self, work: Callable[..., R], arguments: Sequence[tuple[Any, ...]], done: Done = unnoticed) -> list[R]:
        """`work(problem, *each)` of all arguments, in their order."""


def one_after_another(problem: DesignProblem) -> Parts:
    """Does the parts here."""

    def execute(work: Callable[..., R], arguments: Sequence[tuple[Any, ...]], done: Done = unnoticed) -> list[R]:
        results = []
        for index, each in enumerate(arguments):
            results.append(work(problem, *each))
            done(index)
        return results

    return execute
