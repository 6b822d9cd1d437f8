"""Progress and notes on standard error; standard output belongs to results."""

import difflib
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from expdesign.chain.recordings.recordings import Recordings
from expdesign.coordinates import SPATIAL
from expdesign.io.column_names import synonym

_PLAIN_INTERVAL = 5.0
"""s between lines of progress where standard error is not a terminal."""

_ALIKE = frozenset({"repeating", "sweeping"})
"""Stages whose steps cost alike, so that the time of the first ones says how long the others will take."""
_KNOWN = 0.1
"""Share of the steps from which that is said."""

_OF_THE_SHEET = ("do", "plan_row", "remarks")
"""Columns that the laboratory sheet has for people; recordings made from it keep them."""


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
def progress(title: str, where: str = "") -> Iterator[ProgressReport]:
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
def stages(*titles: str) -> Iterator[Callable[[str, int, int, str], None]]:
    """A progress report for each stage of a longer work: called with its title, steps done, steps, and a note.

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
                reports[title] = stack.enter_context(progress(title, where))
            reports[title].update(done, total, note)

        yield report


def note(text: str) -> None:
    """One line on standard error."""
    print(text, file=sys.stderr, flush=True)


def note_unknown_columns(recordings: Recordings) -> None:
    """Say which columns have no meaning here."""
    unknown = [str(name) for name in recordings.extra.columns if name not in _OF_THE_SHEET]
    if unknown:
        names = ", ".join(_with_near(name) for name in unknown)
        note(f"{recordings.source}: columns without a meaning here, kept but not used: {names}")


def _with_near(name: str) -> str:
    """A column with the known one that it resembles: `dx_mm` is in another unit, `dxm` a slip of the pen."""
    known = ["sequence", "series", "time_s", "split", "mass_kg"]
    known += [column for names in vars(SPATIAL).values() if isinstance(names, tuple) for column in names]
    near = difflib.get_close_matches(name, known, n=1, cutoff=0.8)
    other = near[0] if near else synonym(name)
    return f"{name} (is `{other}` meant?)" if other else name
