"""`expdesign compensate`: command poses that reach the targets under load."""

from pathlib import Path
from typing import Annotated, cast

import typer

import expdesign as xd
from expdesign.app.api.inputs import purpose_of
from expdesign.app.commands.writing import Force, OtherRobot, Units, require_file
from expdesign.chain.readings.position import Frame

GROUP = ("way", 7)
"""Where it stands in the list of commands."""


def command(
    model: Annotated[Path, typer.Argument(help="Identified model (YAML).")],
    targets: Annotated[
        Path,
        typer.Argument(
            help="Targets (CSV): where the platform shall be, and the load there; or a run configuration (YAML) with "
            "its targets."
        ),
    ],
    out: Annotated[Path, typer.Option(help="File for the commands.")],
    frame: Annotated[
        str, typer.Option(help="Of the poses of an arm's tip: base, or instrument as it was identified.")
    ] = "base",
    units: Units = None,
    other_robot: OtherRobot = False,
    force: Force = False,
) -> None:
    """Find the commands that bring the platform to the targets under load.

    The load is that at the target: a payload's wrench is taken at the orientation that the platform shall have.

    Example: expdesign compensate results/mine/model.yaml targets.csv --out commands.csv
    """
    require_file(out, purpose_of("compensate", model, targets), force=force)
    result = xd.compensate(model, targets, other_robot=other_robot, frame=cast("Frame", frame))
    result.save(out, units, force=force)
    for line in result.lines:
        print(line)
    print(result.summary)
    print(out)
