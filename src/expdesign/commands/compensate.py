"""`expdesign compensate`: command poses that reach the targets under load."""

from pathlib import Path
from typing import Annotated

import typer

import expdesign as xd
from expdesign.commands.console import note


def command(
    model: Annotated[Path, typer.Argument(help="Identified model (YAML).")],
    targets: Annotated[Path, typer.Argument(help="Targets (CSV): where the platform shall be, and the load there.")],
    out: Annotated[Path, typer.Option(help="File for the commands.")],
    units: Annotated[
        str | None, typer.Option(help="Units to write, by what they measure, e.g. mm,mrad; SI if left out.")
    ] = None,
) -> None:
    """Find the commands that bring the platform to the targets under load.

    The load is that at the target: a payload's wrench is taken at the orientation that the platform shall have.

    Example: expdesign compensate results/mine/model.yaml targets.csv --out commands.csv
    """
    result = xd.compensate(model, targets)
    result.save(out, units)
    found = result.compensation
    note(
        f"{len(result.text)} commands found in {found.iterations} passes "
        f"(predicted pose within {found.residual:.1g} m or rad of the target)"
    )
    print(out)
