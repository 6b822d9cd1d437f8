"""`expdesign run`: the Pareto front of a configuration, its plans and its report."""

import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from expdesign.app.commands import BEGUN
from expdesign.app.commands.call import Call, note


def command(call: Call) -> None:
    """Run, ended by the clock or by a person."""
    call.require_free()
    out, force = call.out, call.given["force"]
    assert out is not None
    further: dict[str, Any] = {"searched": lambda run: run.save_plan(out, force=force)}
    seconds = call.given.get("seconds")
    if seconds is not None and seconds >= 0.0:  # what it took to get here counts too
        further["seconds"] = max(0.0, seconds - (time.perf_counter() - BEGUN))
    with _interruptible() as interrupted:
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
        note("ending; the best plans so far are kept. Ctrl-C again ends without them")

    before = signal.signal(signal.SIGINT, note_it)
    try:
        yield lambda: pressed
    finally:
        signal.signal(signal.SIGINT, before)
