"""Progress of functions that take long: a callback, and on request a bar on standard error."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

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


def silent(stage: str, done: int, total: int, note: str) -> None:
    """No-op progress callback."""


def shows_progress(*titles: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Make the arguments `callback` and `progress` of a function work: with `progress` a bar is shown as well.

    Args:
        titles: of its stages in their order, as far as they are known beforehand.
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        @wraps(function)
        def called(*args: P.args, **kwargs: P.kwargs) -> R:
            if not kwargs.get("progress"):
                return function(*args, **kwargs)
            given: Any = kwargs.get("callback", silent)
            with stages(*titles) as shown:

                def both(stage: str, done: int, total: int, note: str) -> None:
                    shown(stage, done, total, note)
                    given(stage, done, total, note)

                options: dict[str, Any] = {**kwargs, "callback": both}
                return function(*args, **options)

        return called

    return decorate


class ProgressReport:
    """A bar on a terminal, a line now and then elsewhere.

    Args:
        bar: of a terminal, or None.
        title: of the stage.
        where: which stage of how many it is; '' where that is not known.
    """

    def __init__(self, bar: Progress | None, title: str, where: str = "") -> None:
        self._bar = bar
        self._shown = f"{title} ({where})" if where else title
        self._task = bar.add_task(self._shown, total=None, note="", left="") if bar is not None else None
        self._alike = title in _ALIKE
        self._started = self._last = time.monotonic()
        self._first: int | None = None

    def update(self, done: int, total: int, note: str) -> None:
        """`done` of `total` steps are done (0 where their number is not known); `note` says what has been reached."""
        if self._first is None:
            self._first = done
        left = ""
        if self._alike:
            left = remaining(time.monotonic() - self._started, done - self._first, total - self._first)
        if self._bar is not None and self._task is not None:
            self._bar.update(self._task, completed=done, total=total or None, note=note, left=left)
        elif (total and done == total) or time.monotonic() - self._last > _PLAIN_INTERVAL:
            self._last = time.monotonic()
            steps = f"{done}/{total}" if total else ""
            print(" ".join(f"{self._shown}: {steps} {left} {note}".split()), file=sys.stderr, flush=True)


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
def _shown(title: str, where: str = "") -> Iterator[ProgressReport]:
    """A progress report on standard error while the block runs."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield ProgressReport(None, title, where)
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed}/{task.total}"),
        TimeElapsedColumn(),
        TextColumn("{task.fields[left]}"),
        TextColumn("{task.fields[note]}"),
    )
    with Progress(*columns, console=console) as bar:
        yield ProgressReport(bar, title, where)


@contextmanager
def stages(*titles: str) -> Iterator[Callback]:
    """A callback that shows progress on standard error, stage by stage.

    Args:
        titles: of all stages in their order, as far as they are known beforehand.
    """
    with ExitStack() as stack:
        reports: dict[str, ProgressReport] = {}

        def report(title: str, done: int, total: int, note: str) -> None:
            if title not in reports:
                stack.close()  # a terminal shows one bar at a time
                known = title in titles and len(titles) > 1
                where = f"stage {titles.index(title) + 1} of {len(titles)}" if known else ""
                reports[title] = stack.enter_context(_shown(title, where))
            reports[title].update(done, total, note)

        yield report
