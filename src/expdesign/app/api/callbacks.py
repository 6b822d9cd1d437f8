"""Progress of functions that take long: a callback, and on request a bar on standard error."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TimeElapsedColumn

from expdesign.app.api.arguments import named_arguments

P = ParamSpec("P")
R = TypeVar("R")

Callback = Callable[[str, int, int, str], None]
"""Called with the stage, the steps done, the steps in all (0 where their number is not known), and a note."""

_PLAIN_INTERVAL = 5.0
"""s between lines of progress where standard error is not a terminal."""
_ALIKE = frozenset({"repeating", "sweeping"})
"""Stages whose steps cost alike, so that the time of the first ones says how long the others will take."""
_KNOWN = 0.1
"""Share of the steps from which that is said."""
_SHOWN = ("{task.completed}/{task.total}", TimeElapsedColumn(), "{task.fields[left]}", "{task.fields[note]}")


def silent(*reported: object) -> None:
    """Nothing, where nobody listens."""


def shows_progress(*titles: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Make the arguments `callback` and `progress` of a function work: with `progress` a bar is shown as well.

    Args:
        titles: of its stages in their order, as far as they are known beforehand.
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        @named_arguments
        @wraps(function)
        def called(*args: P.args, **kwargs: P.kwargs) -> R:
            if not kwargs.get("progress"):
                return function(*args, **kwargs)
            given: Any = kwargs.get("callback") or silent
            with stages(*titles) as shown:

                def both(stage: str, done: int, total: int, note: str) -> None:
                    shown(stage, done, total, note)
                    given(stage, done, total, note)

                options: dict[str, Any] = {**kwargs, "callback": both}
                return function(*args, **options)

        return called

    return decorate


class ProgressReport:
    """A bar for each stage on a terminal, a line now and then elsewhere.

    Args:
        bars: for a terminal; None elsewhere.
        titles: of all stages in their order, as far as they are known beforehand.
    """

    def __init__(self, bars: Progress | None, titles: tuple[str, ...]) -> None:
        self._bars, self._titles = bars, titles
        self._stage, self._task = "", TaskID(0)
        self._started = self._last = 0.0
        self._first = 0

    def update(self, stage: str, done: int, total: int, note: str) -> None:
        """`done` of `total` steps of a stage are done (0: not known); `note` says what has been reached."""
        shown = stage
        if stage in self._titles and len(self._titles) > 1:
            shown += f" (stage {self._titles.index(stage) + 1} of {len(self._titles)})"
        if stage != self._stage:
            self._stage, self._first, self._started = stage, done, time.monotonic()
            self._last = self._started
            if self._bars is not None:
                self._task = self._bars.add_task(shown, total=None, note="", left="")
        spent = time.monotonic() - self._started
        left = remaining(spent, done - self._first, total - self._first) if stage in _ALIKE else ""
        if self._bars is not None:
            self._bars.update(self._task, completed=done, total=total or None, note=note, left=left)
        elif (total and done == total) or time.monotonic() - self._last > _PLAIN_INTERVAL:
            self._last = time.monotonic()
            steps = f"{done}/{total}" if total else ""
            print(" ".join(f"{shown}: {steps} {left} {note}".split()), file=sys.stderr, flush=True)


def remaining(elapsed: float, done: int, total: int) -> str:
    """How long `total - done` more steps will take if they go on as the first `done` did in `elapsed` s.

    '' before a tenth of them is done, when that cannot be known.
    """
    if not _KNOWN * total <= done < total or done < 1:
        return ""
    seconds = elapsed * (total - done) / done
    minutes = round(seconds / 60.0)
    if seconds < 90.0:
        return f"({seconds:.0f} s left)"
    return f"({minutes} min left)" if minutes < 90 else f"({minutes // 60} h {minutes % 60} min left)"


@contextmanager
def stages(*titles: str) -> Iterator[Callback]:
    """A callback that shows progress on standard error, stage by stage.

    Args:
        titles: of all stages in their order, as far as they are known beforehand.
    """
    console = Console(stderr=True)
    if not console.is_terminal:
        yield ProgressReport(None, titles).update
        return
    with Progress("{task.description}", BarColumn(), *_SHOWN, console=console) as bars:
        yield ProgressReport(bars, titles).update
