"""`expdesign run`: the Pareto front of a configuration, its plans and its report."""

import os
import signal
import sys
import time
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import expdesign as xd
from expdesign.app.api.configuration import problem_of
from expdesign.app.commands import BEGUN
from expdesign.app.commands.call import Call, note


def command(call: Call, watch: bool = False, port: int = 0) -> None:
    """Run, ended by the clock or by a person, and looked at on the way.

    Args:
        call: the command.
        watch: show the front as it grows in the browser, where the run can be ended.
        port: of the page of --watch on this machine; any that is free if 0.
    """
    call.require_free()
    out, force = call.out, call.given["force"]
    assert out is not None
    further: dict[str, Any] = {"searched": lambda run: run.save_plan(out, force=force)}
    seconds = call.given.get("seconds")
    if seconds is not None and seconds >= 0.0:  # what it took to get here counts too
        further["seconds"] = max(0.0, seconds - (time.perf_counter() - BEGUN))
    with _interruptible() as interrupted:
        if watch:
            result, page = _watched(call, port, interrupted, further)
        else:
            result = call.result(ended=interrupted, **further)
            page = call.kept(result)
    call.say(result)
    if result.protocol is not None:
        note(f"{out / 'poses.csv'} has every pose to measure, references included; `expdesign correct` reads it")
    print(page)


@contextmanager
def _interruptible() -> Iterator[Callable[[], bool]]:
    """Whether somebody has pressed Ctrl-C; who presses it twice, ends the program."""
    pressed = False

    def note_it(number: int, frame: object) -> None:
        nonlocal pressed
        if pressed:
            raise KeyboardInterrupt
        pressed = True
        note("ending with the best plans so far; Ctrl-C again ends without them")

    before = signal.signal(signal.SIGINT, note_it)
    try:
        yield lambda: pressed
    finally:
        signal.signal(signal.SIGINT, before)


def _watched(
    call: Call, port: int, interrupted: Callable[[], bool], further: dict[str, Any]
) -> tuple[xd.RunResult, Path | None]:
    """The run with a page on which it can be looked at and ended, and the path of its report."""
    from expdesign.app.watching.server import Watched, serve  # noqa: PLC0415 (needed here alone)

    problem = problem_of(call.given["config"])
    watched = Watched(problem, str(call.out))
    with serve(watched, port) as watch:
        note(f"watch it at {watch.address}")
        _open(watch.address)
        ended = {"ended": lambda: interrupted() or watched.wanted}
        result = call.result(config=problem, callback=watched.stage, follow=watched.follow, **ended, **further)
        watched.stage("writing", 0, 0, "")
        page = call.kept(result)
        watched.ended("ended" if "ended_by_hand" in result.record else "finished")
        watch.report = page
    return result, page


def _open(address: str) -> None:
    """Open a page where a person sits at a screen; elsewhere the address has been said."""
    screen = sys.platform in ("darwin", "win32") or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if sys.stderr.isatty() and screen:
        webbrowser.open(address)
