"""Progress and notes on standard error; standard output belongs to results."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from expdesign.recordings.recordings import Recordings

_PLAIN_INTERVAL = 5.0
"""s between lines of progress where standard error is not a terminal."""


class ProgressReport:
    """A bar on a terminal, a line now and then elsewhere."""

    def __init__(self, bar: Progress | None, title: str) -> None:
        self._bar = bar
        self._task = bar.add_task(title, total=None, note="") if bar is not None else None
        self._title = title
        self._last = time.monotonic()

    def update(self, done: int, total: int, note: str) -> None:
        """`done` of `total` steps are done; `note` says what has been reached."""
        if self._bar is not None and self._task is not None:
            self._bar.update(self._task, completed=done, total=total, note=note)
        elif done == total or time.monotonic() - self._last > _PLAIN_INTERVAL:
            self._last = time.monotonic()
            print(f"{self._title}: {done}/{total} {note}", file=sys.stderr, flush=True)


@contextmanager
def progress(title: str) -> Iterator[ProgressReport]:
    """A progress report on standard error while the block runs."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield ProgressReport(None, title)
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed}/{task.total}"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[note]}"),
    )
    with Progress(*columns, console=console) as bar:
        yield ProgressReport(bar, title)


def note(text: str) -> None:
    """One line on standard error."""
    print(text, file=sys.stderr, flush=True)


def note_unknown_columns(recordings: Recordings) -> None:
    """Say which columns have no meaning here."""
    if len(recordings.extra.columns):
        names = ", ".join(str(name) for name in recordings.extra.columns)
        note(f"{recordings.source}: columns without a meaning here, kept but not used: {names}")
