"""`expdesign sheet`: a plan as a sheet for the laboratory."""

from pathlib import Path
from typing import Annotated

import typer

import expdesign as xd
from expdesign.app.api.inputs import purpose_of
from expdesign.app.commands.writing import Config, Force, PlanPath, Units, require_folder

GROUP = ("way", 4)
"""Where it stands in the list of commands."""


def command(
    config: Config,
    plan: PlanPath,
    out: Annotated[Path, typer.Option(help="Folder for sheet.html, sheet.csv and sheet.xlsx.")],
    units: Units = None,
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
