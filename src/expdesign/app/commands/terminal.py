"""What surrounds a command: an output that may not know every character, or be full, and signals that end it."""

import codecs
import contextlib
import os
import signal
import sys
import unicodedata
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any

_PLAIN = {"\u2212": "-", "\u2013": "-", "\u2026": "...", "\u2192": "->", "\u00b7": "*", "\u00d7": "x", "\u2264": "<=",
          "\u2265": ">=", "\u03c7": "chi", "\u00b5": "u", "\u03bc": "u", "\u03c3": "sigma", "\u00b1": "+-"}  # fmt: skip
"""What stands for characters that an output cannot have: a minus that became `?` would change a number."""
_HANDLER = "expdesign-plain"
_STEERING = ("Cc", "Cf")
"""Categories of characters without a shape of their own: a name in a file may hold them."""


def _plain(error: UnicodeError) -> tuple[str, int]:
    """The characters that could not be encoded in plain letters, `?` where there are none."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    texts = (_PLAIN.get(one) or _letters(one) for one in error.object[error.start : error.end])
    return "".join(texts), error.end


def _letters(one: str) -> str:
    return unicodedata.normalize("NFKD", one).encode("ascii", "ignore").decode("ascii") or "?"


codecs.register_error(_HANDLER, _plain)


def encode_anything() -> None:
    """Let standard output and error write every text, whatever their encoding (cp1252 of a pipe on Windows)."""
    for stream in (sys.stdout, sys.stderr):
        reconfigure: Any = getattr(stream, "reconfigure", None)  # a stream that was put in its place may have none
        if reconfigure is not None:
            reconfigure(errors=_HANDLER)


def printable(text: str) -> str:
    """A line in which characters that steer a terminal, or turn the direction of what follows, are seen as `�`."""
    return "".join("\ufffd" if unicodedata.category(one) in _STEERING and one not in "\n\t" else one for one in text)


def unwritable_output() -> OSError | None:
    """Why standard output cannot take another line; None where it can. What it could not take is given up."""
    try:
        sys.stdout.write("\n")  # what failed may have been written at once, so that nothing is left to flush
        sys.stdout.flush()
    except OSError as error:
        with contextlib.suppress(OSError, ValueError):  # else the interpreter tries again as it ends
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, sys.stdout.fileno())
            os.close(nowhere)
        return error
    return None


@contextlib.contextmanager
def interruptible(note: Callable[[str], None]) -> Iterator[Callable[[], bool]]:
    """Whether somebody has pressed Ctrl-C, which is noted; who presses it twice ends the program."""
    pressed = False

    def press(number: int, frame: FrameType | None) -> None:
        nonlocal pressed
        if pressed:
            raise KeyboardInterrupt
        pressed = True
        note("ending; the best plans so far are kept. Ctrl-C again ends without them")

    before = signal.signal(signal.SIGINT, press)
    try:
        yield lambda: pressed
    finally:
        signal.signal(signal.SIGINT, before)


@contextlib.contextmanager
def terminated_as_interrupted() -> Iterator[None]:
    """SIGTERM (of systemd, Slurm, docker) does what Ctrl-C does at that moment: the best so far is kept."""

    def interrupt(number: int, frame: FrameType | None) -> None:
        handler = signal.getsignal(signal.SIGINT)
        if callable(handler):
            handler(signal.SIGINT, frame)
        else:  # a shell that starts a command in the background makes it ignore Ctrl-C
            raise KeyboardInterrupt

    try:
        before = signal.signal(signal.SIGTERM, interrupt)
    except ValueError:  # not in the main thread, where no signals arrive
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
