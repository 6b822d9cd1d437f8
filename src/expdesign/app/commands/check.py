"""`expdesign check`: what is wrong with a file, or not identifiable."""

import pandas as pd
import typer

import expdesign as xd
from expdesign.app.commands.call import Call, note


def command(call: Call, gradients: bool = False) -> None:
    """Check a file, and on request gradients.

    Args:
        call: the command.
        gradients: compare every criterion's exact gradient with central differences.
    """
    call.require_free()
    checked = call.result()
    call.say(checked, call.kept(checked))
    if gradients and isinstance(checked, xd.CheckedProblem):
        _print_gradients(checked.gradients())


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
