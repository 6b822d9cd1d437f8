"""`expdesign sheet`: a plan as a sheet for the laboratory."""

from pathlib import Path
from typing import Annotated

import typer

import expdesign as xd
from expdesign.commands.console import note
from expdesign.files.output import require_writable


def command(
    config: Annotated[Path, typer.Argument(help="Run configuration (YAML).")],
    plan: Annotated[Path, typer.Argument(help="Plan (CSV).")],
    out: Annotated[Path, typer.Option(help="Folder for sheet.html, sheet.csv and sheet.xlsx.")],
    units: Annotated[
        str | None, typer.Option(help="Units to write, by what they measure, e.g. mm,mrad; SI if left out.")
    ] = None,
) -> None:
    """Write a plan as a sheet for the laboratory, in the order that saves changes; `identify` takes it back filled in.

    Example: expdesign sheet configs/hexapod-h1.yaml results/mine/plan.csv --out results/sheet --units mm,mrad
    """
    require_writable(out)
    result = xd.sheet(config, plan)
    page = result.save(out, units)
    note(result.summary)
    print(page)
