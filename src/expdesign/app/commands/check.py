"""`expdesign check`: what is wrong with a file, or not identifiable."""

import logging

import pandas as pd
import typer

import expdesign as xd
from expdesign.app.commands.call import Call, note


class _Warned(logging.Handler):
    """Counts what is warned of while a file is read."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.count = 0

    def emit(self, record: logging.LogRecord) -> None:
        self.count += 1


def command(call: Call, gradients: bool = False, strict: bool = False) -> None:
    """Check a file, and on request gradients.

    Args:
        call: the command.
        gradients: compare every criterion's exact gradient with central differences.
        strict: exit with status 3 where anything is doubtful.
    """
    call.require_free()
    warned, log = _Warned(), logging.getLogger("expdesign")
    log.addHandler(warned)
    try:
        checked = call.result()
    finally:
        log.removeHandler(warned)
    if gradients and isinstance(checked, xd.CheckedProblem):
        _print_gradients(checked.gradients())
    call.say(checked, call.kept(checked))
    if strict and (warned.count or checked.doubts):
        note("refused (--strict): see the warnings")
        raise typer.Exit(3)


def _print_gradients(table: pd.DataFrame) -> None:
    """Print the table; exit with status 1 where a gradient is wrong."""
    print(
        "Largest relative difference between exact gradients and central differences, over all variables of two "
        "random designs,\nat steps of these parts of each variable's range:"
    )
    print(table.to_string(index=False, float_format=lambda value: f"{value:.1e}", na_rep="-"))
    if (table["verdict"] == "fail").any():
        from expdesign.planning.optimality.gradient_check import ACCEPTED  # noqa: PLC0415 (on request)

        note(f"a gradient is wrong by more than {ACCEPTED:.0e}: see the verdicts")
        raise typer.Exit(1)
