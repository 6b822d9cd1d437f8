"""`expdesign check`: what is wrong with a file, or not identifiable."""

import logging

import typer

from expdesign.app.commands.call import Call, note


class _Warned(logging.Handler):
    """Counts what is warned of while a file is read."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.count = 0

    def emit(self, record: logging.LogRecord) -> None:
        self.count += 1


def command(call: Call, strict: bool = False) -> None:
    """Check a file.

    Args:
        call: the command.
        strict: exit with status 3 where anything is doubtful.
    """
    call.require_free()
    warned, log = _Warned(), logging.getLogger("expdesign")
    log.addHandler(warned)
    try:
        checked = call.result()
    finally:
        log.removeHandler(warned)
    call.say(checked, call.kept(checked))
    if strict and (warned.count or checked.doubts):
        note("refused (--strict): see the warnings")
        raise typer.Exit(3)
