"""`expdesign check`: what is wrong with a file, or not identifiable."""

from pathlib import Path
from typing import Annotated

import pandas as pd
import typer

import expdesign as xd
from expdesign.app.api.check import FILES, Checked, CheckedModel, CheckedProblem, CheckedRecordings, CheckedRobot, save
from expdesign.app.api.inputs import purpose_of
from expdesign.app.commands.console import note, note_unknown_columns
from expdesign.app.commands.writing import Force, SharedReference
from expdesign.errors import InputError
from expdesign.io.output import require_writable
from expdesign.io.written import Purpose, require_free_names
from expdesign.planning.optimality.gradient_check import ACCEPTED

GROUP = ("way", 2)
"""Where it stands in the list of commands."""


def command(
    file: Annotated[Path, typer.Argument(help="A robot, a configuration or a sweep (YAML), or recordings (CSV).")],
    robot: Annotated[Path | None, typer.Option(help="Robot (YAML) that recordings are of.")] = None,
    shared_reference: SharedReference = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for a page with the robot drawn, its legs or joints numbered.")
    ] = None,
    gradients: Annotated[
        bool, typer.Option("--gradients", help="Compare every criterion's exact gradient with central differences.")
    ] = False,
    force: Force = False,
) -> None:
    """Read a robot, a configuration, a sweep or recordings, and say what is wrong or not identifiable.

    Example: expdesign check configs/hexapod-h1.yaml --gradients
    """
    purpose = purpose_of("check", file)
    if out is not None:
        require_writable(out)
        require_free_names(out, FILES, purpose, force=force)
    checked = xd.check(file, robot, shared_reference=shared_reference)
    if isinstance(checked, CheckedRecordings) and checked.recordings is not None:
        note_unknown_columns(checked.recordings)
    for remark in checked.remarks:
        note(remark)
    print(f"{file}: {checked.summary}")
    if isinstance(checked, CheckedRobot | CheckedModel):
        print("\n".join(checked.details))
    if out is not None:
        print(_page(checked, out, file, purpose, force=force))
    if gradients and isinstance(checked, CheckedProblem):
        _print_gradients(checked.gradients())


def _page(checked: Checked, out: Path, file: Path, purpose: Purpose, *, force: bool) -> Path:
    if not isinstance(checked, CheckedRobot | CheckedModel | CheckedProblem):
        remedy = "Give a robot, a model or a run configuration, or leave --out out."
        raise InputError("there is no robot to draw in this file", where=str(file), remedy=remedy)
    return save(checked, out, purpose, force=force)


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
