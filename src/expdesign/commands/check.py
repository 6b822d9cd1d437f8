"""`expdesign check`: what is wrong with a file, or not identifiable."""

from pathlib import Path
from typing import Annotated

import pandas as pd
import typer

import expdesign as xd
from expdesign.api.check import CheckedProblem, CheckedRecordings
from expdesign.commands.console import note, note_unknown_columns
from expdesign.design.optimality.gradient_check import ACCEPTED


def command(
    file: Annotated[Path, typer.Argument(help="A robot, a configuration or a sweep (YAML), or recordings (CSV).")],
    robot: Annotated[Path | None, typer.Option(help="Robot (YAML) that recordings are of.")] = None,
    shared_reference: Annotated[
        bool, typer.Option("--shared-reference", help="Half of each row's variance is common to its series.")
    ] = False,
    gradients: Annotated[
        bool, typer.Option("--gradients", help="Compare every criterion's exact gradient with central differences.")
    ] = False,
) -> None:
    """Read a robot, a configuration, a sweep or recordings, and say what is wrong or not identifiable.

    Example: expdesign check configs/hexapod-h1.yaml --gradients
    """
    checked = xd.check(file, robot, shared_reference=shared_reference)
    if isinstance(checked, CheckedRecordings) and checked.recordings is not None:
        note_unknown_columns(checked.recordings)
    for remark in checked.remarks:
        note(remark)
    print(f"{file}: {checked.summary}")
    if gradients and isinstance(checked, CheckedProblem):
        _print_gradients(checked.gradients())


def _print_gradients(table: pd.DataFrame) -> None:
    """Print the table; exit with status 1 where a gradient is wrong."""
    print(
        "Largest relative difference between exact gradients and central differences, over all variables of two "
        "random designs,\nat steps of these parts of each variable's range:"
    )
    print(table.to_string(index=False, float_format=lambda value: f"{value:.1e}", na_rep="-"))
    if (table["verdict"] == "fail").any():
        note(f"a gradient is wrong by more than {ACCEPTED:.0e}: see the verdicts")
        raise typer.Exit(1)
