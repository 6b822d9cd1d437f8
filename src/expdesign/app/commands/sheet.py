"""`expdesign sheet`: a plan as a sheet for the laboratory."""

from pathlib import Path
from typing import Annotated

import typer

import expdesign as xd
from expdesign.app.api.inputs import purpose_of
from expdesign.app.commands.writing import Force, require_folder

GROUP = ("way", 4)
"""Where it stands in the list of commands."""


def command(
    config: Annotated[Path, typer.Argument(help="Run configuration (YAML).")],
    plan: Annotated[Path, typer.Argument(help="Plan (CSV).")],
    out: Annotated[Path, typer.Option(help="Folder for sheet.html, sheet.csv and sheet.xlsx.")],
    units: Annotated[
        str | None, typer.Option(help="Units to write, by what they measure, e.g. mm,mrad; SI if left out.")
    ] = None,
    force: Force = False,
) -> None:
    """Write a plan as a sheet for the laboratory, in the order that saves changes; `identify` takes it back filled in.

    Example: expdesign sheet configs/hexapod-h1.yaml results/mine/plan.csv --out results/sheet --units mm,mrad
    """
    require_folder(out, xd.SheetResult, purpose_of("sheet", config, plan), force=force)
    result = xd.sheet(config, plan)
    page = result.save(out, units, force=force)
    print(result.summary)
    print(page)
